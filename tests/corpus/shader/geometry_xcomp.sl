surface t() {
    Ci = xcomp(P) + ycomp(P) + zcomp(P);
}
