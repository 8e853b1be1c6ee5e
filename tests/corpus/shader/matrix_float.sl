surface t() {
    Ci = determinant(matrix 2);
}
