surface t() {
    Ci = length(P);
}
