surface t() {
    Ci = log(s + 1, 2);
}
