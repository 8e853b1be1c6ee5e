surface t() {
    Ci = texture("a.tx", 0, 0, 1, 0, 0, 1, 1, 1);
}
