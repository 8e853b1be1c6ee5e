surface t() {
    Ci = floor(xcomp(P));
}
