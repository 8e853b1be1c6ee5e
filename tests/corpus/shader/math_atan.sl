surface t() {
    Ci = atan(xcomp(P));
}
