surface t() {
    Ci = exp(xcomp(P));
}
