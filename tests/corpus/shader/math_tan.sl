surface t() {
    Ci = tan(xcomp(P));
}
