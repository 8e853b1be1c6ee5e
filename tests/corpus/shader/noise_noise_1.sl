surface t() {
    Ci = noise(s);
}
