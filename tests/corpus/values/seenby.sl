light seenby() { solar(vector(0, 0, 1), 0) { Cl = -zcomp(E) / 10; } }
