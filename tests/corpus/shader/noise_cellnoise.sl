surface t() {
    Ci = cellnoise(P);
}
