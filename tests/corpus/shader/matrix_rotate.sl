surface t() {
    Ci = xcomp(transform(rotate(1, 0.5, vector(0,0,1)), P));
}
