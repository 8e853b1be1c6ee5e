light l(string map = "";) { solar() { Cl = map == "" ? color 1 : environment(map, -L); } }
