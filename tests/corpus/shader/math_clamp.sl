surface t() {
    Ci = clamp(s, 0.2, 0.8);
}
