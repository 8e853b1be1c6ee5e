void split(color c; output float r; output float g) { r = comp(c, 0); g = comp(c, 1); }
surface t() { float r, g; split(Cs, r, g); Ci = r + g; }
