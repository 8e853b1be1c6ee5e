surface t() {
    Ci = color "rgb" (0.2, 0.4, 0.6);
}
