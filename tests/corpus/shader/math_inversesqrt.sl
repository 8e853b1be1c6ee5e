surface t() {
    Ci = inversesqrt(xcomp(P));
}
