float a(float x) { return x + 1; }
float b(float x) { return a(a(x)); }
surface t() { Ci = b(s); }
