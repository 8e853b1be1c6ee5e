surface t() {
    Ci = color "xyY" (0.2, 0.4, 0.6);
}
