// Outputs of all kinds, conditional expressions.
surface passes(output varying color albedo = 0; output varying float depthv = 0; output varying normal nn = 0;
  output float mask = 0;) {
  albedo = s > .5 ? color(1,t,0) : (t > .5 ? color(0,1,s) : color(s,t,1)); depthv = length(I); nn = normalize(N);
  mask = (s < .3 && t > .2 || !(s > .1)) ? 1 : 0; Ci = albedo * (.4+.6*mask); Oi = 1;
}
