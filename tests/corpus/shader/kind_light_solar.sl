light l(float intensity = 1;) { solar(vector(0, 0, -1), 0) { Cl = intensity; } }
