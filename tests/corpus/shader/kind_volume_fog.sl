volume v(float distance = 10; color background = 0.5;) { float d = 1 - exp(-length(I) / distance); Ci = mix(Ci, background, d); Oi = mix(Oi, color 1, d); }
