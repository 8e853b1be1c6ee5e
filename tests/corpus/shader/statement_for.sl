surface t() {
    float i; for (i = 0; i < 4; i += 1) Ci += i;
}
