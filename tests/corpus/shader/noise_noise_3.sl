surface t() {
    Ci = noise(P);
}
