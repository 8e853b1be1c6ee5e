float f(float x) { return f(x); } // FAULT
surface t() { Ci = f(1); }
