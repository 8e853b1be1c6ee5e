surface t() {
    Ci = acos(xcomp(P));
}
