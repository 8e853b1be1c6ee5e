surface place(varying point at = 0;) { Oi = 1; Ci = color(at); }
