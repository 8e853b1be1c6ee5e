surface t() {
    Ci = min(s, t);
}
