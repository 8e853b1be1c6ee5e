surface t() {
    Ci = atan(s, t);
}
