surface t() {
    Ci = mod(s * 10, 3);
}
