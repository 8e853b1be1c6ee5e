// Arrays, functions with outputs, loops that are left from within.
void stats(float v[4]; output float lo; output float hi) {
  uniform float i; lo = v[0]; hi = v[0];
  for (i = 1; i < 4; i += 1) { lo = min(lo, v[i]); hi = max(hi, v[i]); }
}
surface tints(float w[4] = {0.1, 0.7, 0.4, 0.9}; color tint[3] = {(1,.2,.1), (.1,1,.2), (.2,.1,1)};) {
  float v[4]; float i, j, k = 0, lo, hi;
  for (i = 0; i < 4; i += 1) v[i] = w[i] + 0.3*sin(7*s + i*t*3);
  stats(v, lo, hi);
  for (i = 0; i < 6; i += 1) {
    for (j = 0; j < 6; j += 1) {
      if (j > 4*s) break;
      if (mod(i+j, 3) == 1) continue;
      if (i*j > 9*t) break 2;
      k += 1;
    }
  }
  float which = floor(mod(k, 3));
  Ci = tint[which]*(0.3+0.7*v[mod(k,4)]) + 0.1*(hi-lo); Oi = Os; Ci *= Oi;
}
