surface s() {
    matrix m = 1;
    Ci = m * P; // FAULT
}
