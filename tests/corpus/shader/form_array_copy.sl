surface t() { float a[3] = {1, 2, 3}; float b[3]; b = a; Ci = b[2]; }
