surface t() {
    Ci = degrees(xcomp(P));
}
