displacement d(float Km = 0.1;) { point q = transform("shader", P); P += Km * sin(xcomp(q) * 20) * normalize(N); N = calculatenormal(P); }
