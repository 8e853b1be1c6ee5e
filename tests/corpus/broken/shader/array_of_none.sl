surface s() {
    float a[0]; // FAULT
    Ci = a[0];
}
