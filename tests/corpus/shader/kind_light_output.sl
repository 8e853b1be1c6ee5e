light l(output float power = 0; string __category = "key";) { illuminate(point(0, 0, 2)) { power = 1 / (L . L); Cl = power; } }
