float g(float x) { extern float y; return y; }
float h(float x) { return k(x); }
float k(float x) { return h(x); }
surface calls_each_other() { Ci = h(3); }