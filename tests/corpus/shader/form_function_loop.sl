float f(float x) { float i; for (i = 0; i < 9; i += 1) if (i > x) return i; return 9; }
surface t() { Ci = f(s * 9); }
