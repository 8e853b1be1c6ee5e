surface t() {
    Ci = s > 0.5 ? color(1, 0, 0) : color(0, 0, 1);
}
