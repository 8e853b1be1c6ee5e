surface t() {
    Ci = xcomp(calculatenormal(P));
}
