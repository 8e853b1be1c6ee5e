surface t() {
    Ci = round(xcomp(P));
}
