surface t(float a[3] = {1, 2, 3}; color c[2] = {color 0, color 1};) { Ci = a[0] + c[1]; }
