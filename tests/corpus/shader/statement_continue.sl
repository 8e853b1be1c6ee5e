surface t() {
    float i; for (i = 0; i < 4; i += 1) { if (i == 2) continue; Ci += 1; }
}
