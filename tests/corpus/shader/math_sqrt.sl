surface t() {
    Ci = sqrt(xcomp(P));
}
