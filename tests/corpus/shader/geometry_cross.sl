surface t() {
    Ci = xcomp(N ^ I);
}
