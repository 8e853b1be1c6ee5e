surface s() {
    Ci = spline("bezier", 0.5, 0, 0, 1, 1, 2); // FAULT
}
