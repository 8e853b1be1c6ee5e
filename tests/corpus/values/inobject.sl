surface inobject() { Oi = 1; Ci = color(transform("object", P)); }
