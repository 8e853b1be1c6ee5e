// Derivatives of every kind, the area and the normal of a surface.
surface ripples() {
  float f = sin(20*s)*cos(15*t);
  float fu = Du(f), fv = Dv(f); vector d = Du(P); float a = area(P); color cu = Du(color(s*s, t*t, s*t));
  float fw = abs(Du(f)*du) + abs(Dv(f)*dv);
  normal n = calculatenormal(P + 0.02*normalize(N)*f);
  Ci = color(abs(fu), abs(fv), 0)/20 + 0.1*length(d)/6 + 20*a*0 + abs(cu)*.2 + fw*.4
  + .2*abs(normalize(n).normalize(I)); Oi = 1;
  Ci += 0.1 * clamp(Deriv(f, s)/20, -1, 1) + .05*clamp(Deriv(s*t, t),0,1);
}
