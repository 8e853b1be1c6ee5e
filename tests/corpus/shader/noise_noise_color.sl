surface t() {
    Ci = color noise(P);
}
