surface s() {
    Ci = spline("bezie", 0.5, 0, 0, 1, 1); // FAULT
}
