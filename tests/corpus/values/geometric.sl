surface geometric() { Oi = 1; Ci = color(normalize(Ng)); }
