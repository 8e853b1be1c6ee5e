surface t() {
    Ci = area(P);
}
