surface t() {
    float k = 0; illuminance(P, N, PI / 2, "light:intensity", k) { Ci += Cl * k; }
}
