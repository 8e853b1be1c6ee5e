surface beyond() { Oi = 1; Ci = trace(P, vector(0, 0, 1)); }
