light faces() { illuminate(P) { Cl = color(abs(normalize(Ng))); } }
