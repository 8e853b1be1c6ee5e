volume where() { Ci = color(transform("shader", P)); }
