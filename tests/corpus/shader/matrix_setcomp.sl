surface t() {
    matrix m = 1; setcomp(m, 3, 0, 5); Ci = comp(m, 3, 0);
}
