surface t() {
    Ci = mix(Cs, color 1, 0.5);
}
