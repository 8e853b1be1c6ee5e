surface cone() {
    float q = 0;
    illuminance(P, vector (0, 0, -1), xcomp(P) < 0 ? 0.1 : PI / 2) { q += 1; }
    Oi = 1;
    Ci = q;
}
