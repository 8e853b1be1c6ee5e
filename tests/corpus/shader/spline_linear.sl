surface t() {
    Ci = spline("linear", s, 0, 0.2, 0.8, 1);
}
