light cone_of_its_own() { illuminate(point "shader" (0, 0, -1), vector "shader" (0, 0, 1), 0.3) { Cl = 1; } }
