surface s() {
    float a[3] = {1, 2, 3};
    Ci = a[3]; // FAULT
}
