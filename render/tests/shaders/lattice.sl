// Opacities that change from point to point.
surface lattice(float holes = 6;) {
  float h = mod(floor(s*holes)+floor(t*holes),2); Oi = h < .5 ? Os*.4 : Os*color(.9,.5,.7);
  Ci = Oi*Cs*(.4+.6*abs(normalize(N).normalize(I)));
  if (cellnoise(s*holes, t*holes) > .85) { Oi = 0; Ci = 0; }
}
