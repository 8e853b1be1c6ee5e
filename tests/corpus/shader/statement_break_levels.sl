surface t() {
    float i, j; for (i = 0; i < 3; i += 1) for (j = 0; j < 3; j += 1) { if (j > s * 3) break 2; Ci += 1; }
}
