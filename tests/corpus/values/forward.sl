surface forward() { Oi = 1; Ci = color(faceforward(normalize(N), I)); }
