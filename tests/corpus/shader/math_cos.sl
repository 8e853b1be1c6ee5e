surface t() {
    Ci = cos(xcomp(P));
}
