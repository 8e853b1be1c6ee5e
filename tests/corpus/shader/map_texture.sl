surface t() {
    Ci = texture("a.tx");
}
