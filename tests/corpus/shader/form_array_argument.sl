float sum(float a[3]) { return a[0] + a[1] + a[2]; }
surface t() { float a[3] = {1, 2, 3}; Ci = sum(a); }
