surface through() { Oi = 1; Ci = raylevel() > 0 ? color 1 : trace(P, vector(0, 0, 1)); }
