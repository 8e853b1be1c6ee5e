surface s() {
    Ci = color "hvs" (1, 1, 1); // FAULT
}
