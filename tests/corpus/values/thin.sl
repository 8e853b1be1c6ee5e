light thin() { solar(vector(0, 0, 1), 0) { Cl = 1; Ol = color(.1, .2, .3); } }
