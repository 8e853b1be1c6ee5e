surface t() {
    Ci = spline("hermite", s, 0, 0.2, 0.8, 1);
}
