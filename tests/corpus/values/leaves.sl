light leaves() {
    uniform float i;
    float n = 0;
    for (i = 0; i < 4; i += 1) {
        solar(vector(0, 0, 1), 0) { if (i == 1) break; }
        n += 1;
    }
    solar(vector(0, 0, 1), 0) { Cl = n / 4; }
}
