surface t() {
    Ci = log(xcomp(P));
}
