surface t() {
    Ci = (matrix 1 == 1) ? 1 : 0;
}
