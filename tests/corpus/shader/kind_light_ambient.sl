light l(float intensity = 1; color lightcolor = 1;) { Cl = intensity * lightcolor; }
