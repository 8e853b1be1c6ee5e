// Maps: channels, widths, filters, places of their own, what a map is.
surface decals(string map = "map.tif"; string env="env.tif";) {
  color a = texture(map, s, t), b = texture(map, s*3, t*3, "blur", .02), e = environment(env, reflect(normalize(I),
  faceforward(normalize(N),I)));
  float f = texture(map[0], s, t), g = texture(map[1], 2*s, 2*t, "swidth", 2, "twidth", 2, "filter", "box");
  color h = texture(map, s, t, s+.01, t, s, t+.01, s+.01, t+.01);
  float has = 0; float rs[2]; has = textureinfo(map, "resolution", rs);
  Ci = (a + b + e + f + g + h)/6 * has; Oi = 1;
}
