// Casts to all kinds, matrices, spaces, components.
surface spaces() {
  point p = point "object" (.1,.2,.3); vector v = vector "world" (0,1,0); normal n = normal "camera" (0,0,-1);
  matrix m = matrix "object" (1,.1,0,0, 0,1,.2,0, 0,0,1,0, .3,0,0,1); matrix r = rotate(m, .4, vector(0,1,0));
  matrix sc = scale(r, point(1,2,1)); matrix tr = translate(sc, point(.1,0,0));
  color c = color "hsv" (mod(s,1),.8,.9); color l = color "hsl"(t,.5,.5); color y = color "YIQ"(.5,.2*s,.1);
  color x = ctransform("rgb","hsv",c);
  vector w = (vector p) - v + vector n; float d = determinant(tr); matrix iv = 1/tr;
  point q = transform(iv, transform(tr, P));
  vector ax = vtransform("object", v); normal nn = ntransform("object", N);
  point o = transform("world","object",point(0,0,0));
  Ci = (c + l + y + x)/4 + .05*color(xcomp(w), ycomp(w), zcomp(w)) + .01*d + distance(q,P)
  + .1*color(xcomp(ax),ycomp(ax),zcomp(ax)) + .1*abs(normalize(nn).normalize(vector(1,1,1)))
  + 0.02*length(o-point(0,0,0));
  setcomp(Ci, 1, comp(Ci,1)*.8); color cc = Ci; setcomp(cc, 0, .9*comp(cc,0)); Ci = cc; Oi = 1;
  float e = comp(tr, 3, 0) + comp(r, 0, 2); Ci += .05*e;
}
