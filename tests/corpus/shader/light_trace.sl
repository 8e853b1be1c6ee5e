surface t() {
    Ci = trace(P, reflect(I, N));
}
