surface t() {
    Ci = xcomp(transform("object", matrix 2, P));
}
