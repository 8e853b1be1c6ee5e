surface t() {
    Ci = pnoise(P, time, point(4, 4, 4), 2);
}
