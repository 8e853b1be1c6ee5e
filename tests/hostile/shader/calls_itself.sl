float f(float x) { return f(x - 1); }
surface calls_itself() { Ci = f(3); }