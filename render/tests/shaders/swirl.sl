// A displacement in a space of its own, by a function of vectors.
vector swirl(point p; uniform float k) { float a = k*zcomp(p); return vector(-sin(a)*ycomp(p), cos(a)*xcomp(p), 0); }
displacement swirl(float amp[3] = {.05,.03,.02};) {
  point p = transform("shader", P); vector v = 0; uniform float i; for (i = 0; i < 3;
  i += 1) v += amp[i]*swirl(p*(1+i), 2+i);
  P = transform("shader","current", p + v); N = calculatenormal(P);
}
