surface t(float k = 2;) { float f(float x) { extern float k; return k * x; } Ci = f(s); }
