surface t() {
    Ci = pow(s, 2);
}
