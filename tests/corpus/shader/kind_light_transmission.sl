light l() { solar(vector(0, 0, -1), 0) { Cl = transmission(Ps, Ps - L * 1000); } }
