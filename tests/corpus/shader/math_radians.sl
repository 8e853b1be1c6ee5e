surface t() {
    Ci = radians(xcomp(P));
}
