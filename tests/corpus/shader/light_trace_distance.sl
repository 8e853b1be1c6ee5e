surface t() {
    float d = trace(P, N); Ci = d;
}
