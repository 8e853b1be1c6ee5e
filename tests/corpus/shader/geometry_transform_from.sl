surface t() {
    Ci = xcomp(transform("object", "camera", P));
}
