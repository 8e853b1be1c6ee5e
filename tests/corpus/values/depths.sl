surface depths() { Oi = 1; Ci = zcomp(P); }
