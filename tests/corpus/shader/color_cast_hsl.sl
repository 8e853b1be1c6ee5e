surface t() {
    Ci = color "hsl" (0.2, 0.4, 0.6);
}
