surface t() {
    Ci = determinant(matrix 2 / matrix 4);
}
