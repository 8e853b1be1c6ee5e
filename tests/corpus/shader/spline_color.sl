surface t() {
    Ci = spline(s, color 0, color(1,0,0), color(0,1,0), color(0,0,1), color 1);
}
