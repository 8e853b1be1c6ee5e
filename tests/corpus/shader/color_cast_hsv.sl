surface t() {
    Ci = color "hsv" (0.2, 0.4, 0.6);
}
