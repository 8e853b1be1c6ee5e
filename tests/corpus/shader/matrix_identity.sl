surface t() {
    Ci = comp(matrix 1, 0, 0);
}
