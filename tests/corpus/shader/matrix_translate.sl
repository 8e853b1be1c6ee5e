surface t() {
    Ci = xcomp(transform(translate(1, vector(1,2,3)), P));
}
