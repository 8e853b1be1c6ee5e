surface t() {
    Ci = ceil(xcomp(P));
}
