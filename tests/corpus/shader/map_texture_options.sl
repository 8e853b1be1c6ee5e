surface t() {
    Ci = texture("a.tx", s, t, "width", 2, "blur", 0.01, "filter", "box");
}
