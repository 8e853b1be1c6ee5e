surface t() {
    Ci = float texture("a.tx"[1], s, t);
}
