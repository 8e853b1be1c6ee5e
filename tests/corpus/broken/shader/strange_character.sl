surface t() {
    Ci = 1 @ 2; // FAULT
}
