surface t() {
    Ci = xcomp(transform("world", P));
}
