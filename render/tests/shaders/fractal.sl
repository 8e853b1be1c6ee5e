// Functions that call functions, with loops that are left at each point elsewhere.
float tri(float x) { return abs(mod(x,2)-1); }
float fold(float x; uniform float n) { float y = x; uniform float k; for (k = 0; k < n; k += 1) { y = tri(2*y + .3);
  } return y; }
color pal(float x) { return x < .33 ? color(1,.5,.2) : x < .66 ? color(.2,.8,.4) : color(.3,.3,.9); }
surface fractal() { float f = fold(s, 4), g = fold(t + f, 3); color c = pal(f); float z = 0, zi = 0, n;
  for (n = 0; n < 24; n += 1) { float zz = z*z - zi*zi + 3*s - 2; zi = 2*z*zi + 2.4*t - 1.2; z = zz;
  if (z*z + zi*zi > 4) break; }
  Ci = c*(.3 + .7*g)*.6 + .4*n/24; Oi = 1; }
