// A march through noise.
volume haze(float den = .08; color fog = color(.5,.6,.8); float step = .5;) {
  float len = length(I), x; color f = 0; float tr = 1; vector dir = normalize(I);
  for (x = step/2; x < len && tr > .05; x += step) { float k = den*step*(0.5 + noise(P - I + x*dir)); f += tr*k*fog;
  tr *= 1-k; }
  Ci = Ci*tr + f; Oi = 1 - tr*(1-Oi);
}
