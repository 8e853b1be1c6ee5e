surface t() {
    Ci = determinant(mtransform("world", matrix 2));
}
