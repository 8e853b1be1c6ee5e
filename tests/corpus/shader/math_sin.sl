surface t() {
    Ci = sin(xcomp(P));
}
