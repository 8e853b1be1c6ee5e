surface s() {
    float k[3] = {0, 1, 2};
    Ci = spline(0.5, k); // FAULT
}
