surface t() {
    Ci = 1;