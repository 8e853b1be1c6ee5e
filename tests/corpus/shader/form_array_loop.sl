surface t() { float a[4]; float i; for (i = 0; i < 4; i += 1) a[i] = i; Ci = a[floor(s * 3)]; }
