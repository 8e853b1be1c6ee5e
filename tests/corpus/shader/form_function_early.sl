float f(float x) { if (x > 0.5) return 1; return x; }
surface t() { Ci = f(s); }
