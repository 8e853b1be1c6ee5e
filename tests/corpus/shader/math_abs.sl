surface t() {
    Ci = abs(xcomp(P));
}
