surface t() {
    Ci = cellnoise(s, t);
}
