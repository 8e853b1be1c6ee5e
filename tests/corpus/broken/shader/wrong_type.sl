surface t() {
    float x = P; // FAULT
}
