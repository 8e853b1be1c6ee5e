surface t() {
    Ci = 1 + 2 * 3 - 4 / 2 + (P ^ N) . N;
}
