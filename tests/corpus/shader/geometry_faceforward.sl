surface t() {
    Ci = xcomp(faceforward(N, I));
}
