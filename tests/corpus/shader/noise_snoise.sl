surface t() {
    Ci = snoise(P);
}
