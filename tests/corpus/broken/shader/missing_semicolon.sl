surface t() {
    Ci = 1
    Oi = 1; // FAULT
}
