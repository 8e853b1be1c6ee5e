surface t() {
    Ci = xcomp(transform(scale(1, point(1,2,3)), P));
}
