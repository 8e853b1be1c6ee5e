surface t() {
    Ci = pnoise(s, t, 4, 4);
}
