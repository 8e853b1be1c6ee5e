surface t() {
    float a = 1, b = a + 1, c; uniform float d = 2; varying color e = 1; c = a + b + d; Ci = c * e;
}
