surface t() {
    float a = 1; a += 2; a -= 1; a *= 3; a /= 2; Ci = -a + !0;
}
