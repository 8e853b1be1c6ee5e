surface t() {
    point p = (1, 2, 3); vector v = (0, 0, 1); normal n = v; color c = (s, t, 0); Ci = c * (p . v) * (n . v);
}
