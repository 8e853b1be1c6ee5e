surface t() {
    Ci = xcomp(normalize(N));
}
