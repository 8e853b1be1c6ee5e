surface t() {
    Ci = sign(xcomp(P));
}
