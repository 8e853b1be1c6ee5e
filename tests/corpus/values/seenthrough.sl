volume seenthrough() { Ci = -zcomp(E) / 10; }
