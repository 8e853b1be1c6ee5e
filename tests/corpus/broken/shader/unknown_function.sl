surface t() {
    Ci = difuse(N); // FAULT
}
