surface t() {
    float x = s; while (x < 10) x *= 2; Ci = x;
}
