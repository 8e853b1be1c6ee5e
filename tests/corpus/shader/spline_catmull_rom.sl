surface t() {
    Ci = spline("catmull-rom", s, 0, 0.2, 0.8, 1);
}
