surface t() {
    Ci = color random();
}
