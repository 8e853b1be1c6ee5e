// Categories of lights, what they output, a loop over lights that is left.
surface studio(float Ks=.5;) {
  normal n = faceforward(normalize(N), I); color c = 0; float wr = 0; float q = 0; string nm;
  illuminance("key", P, n, PI/2) {
    float p = 0; vector l = normalize(L);
    if (lightsource("power", p) == 1) q += p;
    float at = 0; lightsource("__spec", at);
    c += Cl * (n.l) * (1 + 0.1*p) + at * Ks * Cl * pow(max(0, n.normalize(l - normalize(I))), 20);
  }
  illuminance("-key", P) { wr += 1; c += 0.2*Cl*abs(n.normalize(L)); if (wr > 2) break; }
  Ci = Cs * c + 0.02*q; Oi = 1;
}
