surface t() {
    Ci = noise(s, t);
}
