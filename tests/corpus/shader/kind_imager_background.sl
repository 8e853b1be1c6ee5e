imager i(color bg = 0.5;) { Ci += (1 - alpha) * bg; alpha = 1; }
