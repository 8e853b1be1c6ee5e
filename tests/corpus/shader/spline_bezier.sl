surface t() {
    Ci = spline("bezier", s, 0, 0.2, 0.8, 1);
}
