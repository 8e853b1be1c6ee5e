surface t() {
    float i; for (i = 0; i < 4; i += 1) { if (i > s * 4) break; Ci += 1; }
}
