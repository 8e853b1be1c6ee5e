surface velocity() { Oi = 1; Ci = color(xcomp(dPdtime), ycomp(dPdtime), zcomp(dPdtime)); }
