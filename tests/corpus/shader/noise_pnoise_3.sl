surface t() {
    Ci = pnoise(P, point(4, 4, 4));
}
