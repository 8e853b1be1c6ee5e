surface t() {
    Ci = color "xyz" (0.2, 0.4, 0.6);
}
