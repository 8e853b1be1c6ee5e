surface t() {
    Ci = Cz; // FAULT
}
