surface t() {
    Ci = determinant(matrix "shader" 1);
}
