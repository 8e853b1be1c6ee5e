// Geometry: Fresnel terms, refraction, rotation, distances.
surface glaze() {
  normal n = normalize(N); vector i = normalize(I); float kr, kt; vector r, tt;
  fresnel(i, faceforward(n,i), 1/1.4, kr, kt, r, tt);
  vector rf = refract(i, faceforward(n,i), .8); point rot = rotate(P, .7, point(0,0,0), point(0,1,1));
  float pl = ptlined(point "world" (-1,-1,-1), point "world"(1,1,1), P); float dp = depth(P);
  Ci = color(kr,kt*.5,abs(r.tt)*.5) + .1*abs(rf.n) + .05*distance(rot,P) + .1*pl + .2*dp*0 + .1*(n^i).(n^i); Oi=1;
}
