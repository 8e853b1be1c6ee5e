surface t() {
    Ci = Deriv(s, t);
}
