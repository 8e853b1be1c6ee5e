float sq(float x) { return x * x; }
surface t() { Ci = sq(s); }
