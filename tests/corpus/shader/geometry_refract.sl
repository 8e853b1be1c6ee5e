surface t() {
    Ci = xcomp(refract(I, N, 0.7));
}
