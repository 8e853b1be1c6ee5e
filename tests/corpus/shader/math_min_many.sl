surface t() {
    Ci = min(s, t, 0.5, u);
}
