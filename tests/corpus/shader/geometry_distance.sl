surface t() {
    Ci = distance(P, point(0, 0, 0));
}
