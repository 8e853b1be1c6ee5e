surface t() {
    Ci = max(s, t);
}
