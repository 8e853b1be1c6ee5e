surface t() {
    Ci = random();
}
