// Noise of one to four dimensions, periodic and in cells, as numbers, colours and points.
surface marble(float freq = 3;) {
  point p = transform("object", P) * freq;
  color c = noise(p); color d = color noise(s*7, t*9); float e = float noise(s*4); point q = point noise(p, 0.3);
  float pn = pnoise(p, point(4,4,4)); color cp = pnoise(s*8, t*8, 4, 4);
  vector vp = vector pnoise(p, 1.4, point(3,3,3), 5);
  float cn = cellnoise(p), c2 = cellnoise(s*6,t*6); color c3 = cellnoise(p, .7); float c4 = float pnoise(s*5, 3);
  Ci = (c + d + color(e) + color(xcomp(q),ycomp(q),zcomp(q)) + pn + cp + color(xcomp(vp),ycomp(vp),zcomp(vp)) + cn
  + c2 + c3 + c4)/11;
  Oi = 1;
  float k, amp = .5, sum = 0; for (k = 0; k < 5; k += 1) { sum += amp*abs(2*noise(p*pow(2,k))-1); amp *= .5; }
  Ci = mix(Ci, color(sum), .4);
}
