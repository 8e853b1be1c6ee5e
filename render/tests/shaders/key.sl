// A lamp that outputs how strong it is.
light key(string __category = "key,studio"; float __spec = 0.7; float intensity = 40; output float power = 0;
  point at = point "shader" (2,3,-3); ) {
  illuminate(at) { power = 2 + noise(3*Ps); Cl = intensity * color(1,.9,.7) / (L.L); }
}
