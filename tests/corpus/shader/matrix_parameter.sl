surface t(matrix m = 1;) {
    Ci = xcomp(transform(m, P));
}
