surface t() {
    Ci = spline("bspline", s, 0, 0.2, 0.8, 1);
}
