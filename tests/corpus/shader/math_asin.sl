surface t() {
    Ci = asin(xcomp(P));
}
