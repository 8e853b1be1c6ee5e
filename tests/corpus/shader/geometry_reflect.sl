surface t() {
    Ci = xcomp(reflect(I, N));
}
