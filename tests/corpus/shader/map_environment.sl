surface t() {
    Ci = environment("e.env", reflect(I, N));
}
