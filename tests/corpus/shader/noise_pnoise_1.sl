surface t() {
    Ci = pnoise(s, 4);
}
