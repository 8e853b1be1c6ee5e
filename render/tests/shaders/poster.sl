// A background, a vignette and stripes.
imager poster(color bg = color(.1,.2,.4); float vig = .4;) {
  float r = distance(point(xcomp(P)/96, ycomp(P)/72, 0), point(.5,.5,0));
  color back = mix(bg, color(.9,.7,.5), ycomp(P)/72); Ci += (1-Oi)*back;
  float lum = comp(Ci,0)*.3+comp(Ci,1)*.6+comp(Ci,2)*.1; Ci = mix(Ci, color(lum), .3) * (1 - vig*r*r); Oi = 1;
  if (mod(floor(xcomp(P)),16) == 0) Ci *= .9;
}
