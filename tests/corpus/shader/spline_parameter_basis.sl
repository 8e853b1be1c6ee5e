surface t(string basis = "linear";) {
    Ci = spline(basis, s, 0, 0, 1, 1);
}
