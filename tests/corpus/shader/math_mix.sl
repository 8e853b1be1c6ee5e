surface t() {
    Ci = mix(color(1, 0, 0), color(0, 0, 1), s);
}
