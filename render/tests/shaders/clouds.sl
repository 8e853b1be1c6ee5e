// A sun through noise.
light clouds(vector way = vector "shader"(.4,-.5,1); float a = 0.0;) {
  solar(way, a) { float m = smoothstep(.3,.6,noise(2*Ps)); Cl = mix(color(.3,.3,.4), color(.9,.8,.6), m);
  Cl *= transmission(Ps, Ps - 50*normalize(L)); }
}
