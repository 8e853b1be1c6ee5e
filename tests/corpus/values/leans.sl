displacement leans() { P += vector(0, 0, xcomp(P)); }
