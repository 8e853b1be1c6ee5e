surface eye() { Oi = 1; Ci = -color(E); }
