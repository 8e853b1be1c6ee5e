surface t() {
    Ci = comp(point noise(P), 0);
}
