surface t() {
    Ci = 1 - shadow("s.sm", P, "samples", 8);
}
