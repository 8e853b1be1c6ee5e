// Rays: occlusion, distances, gather, transmission.
surface probes(float n = 16;) {
  normal f = faceforward(normalize(N), I); float occ = occlusion(P, f, n);
  float d = trace(P, reflect(normalize(I), f));
  float hits = 0, total = 0, dist = 0;
  gather("", P, vector f, PI/4, 12, "ray:length", dist) { hits += 1/(1+dist); total += 1; } else { total += 1; }
  color tr = transmission(P, P + 5*vector "world" (-.4,.5,-1));
  Ci = .5*(1-occ) + .1*min(d,3) + .3*hits/total + .2*tr; Oi = 1;
}
