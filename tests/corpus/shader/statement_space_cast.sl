surface t() {
    point p = point "world" (0, 0, 0); vector v = vector "object" (0, 0, 1); Ci = length(p) + length(v);
}
