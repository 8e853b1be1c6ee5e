surface t() {
    Ci = color "YIQ" (0.2, 0.4, 0.6);
}
