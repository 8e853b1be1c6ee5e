surface t() {
    Ci = step(0.5, s);
}
