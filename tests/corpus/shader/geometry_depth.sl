surface t() {
    Ci = depth(P);
}
