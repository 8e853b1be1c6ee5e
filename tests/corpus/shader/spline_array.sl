surface t(float k[5] = {0, 0.1, 0.5, 0.9, 1};) {
    Ci = spline(s, k);
}
