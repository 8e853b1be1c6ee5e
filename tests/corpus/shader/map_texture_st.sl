surface t() {
    Ci = texture("a.tx", s, t);
}
