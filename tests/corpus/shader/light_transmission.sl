surface t() {
    Ci = transmission(P, P + N);
}
