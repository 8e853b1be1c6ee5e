// Displacement by nested loops and conditions.
displacement cobbles(float Km = .12; float rows = 4;) {
  float h = 0, i, j; normal n = normalize(N);
  for (i = 0; i < rows; i += 1) {
    if (mod(i, 2) < 1) {
      j = 0;
      while (j < 3) {
        j += 1;
        if (sin(9*s + i) > .9) continue;
        if (noise(6*s, 6*t + j) > .6) { h += .2; if (h > .8) break; }
        else h -= .05;
      }
    } else if (t > .5) h += .1*smoothstep(.5,.6,t); else { h += .1*cellnoise(s*4,t*4)*0; }
  }
  P += Km * clamp(h,-1,1) * n * smoothstep(0,.1,t) * smoothstep(1,.9,t); N = calculatenormal(P);
}
