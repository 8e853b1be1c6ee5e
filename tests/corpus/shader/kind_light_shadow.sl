light l(string map = "raytrace"; point from = (0, 0, 5);) { illuminate(from) { Cl = 1 - shadow(map, Ps); } }
