surface t() {
    Ci = clamp(Cs, color 0, color 1);
}
