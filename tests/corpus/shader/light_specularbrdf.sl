surface t() {
    illuminance(P, N, PI / 2) { Ci += Cl * specularbrdf(normalize(L), normalize(N), -normalize(I), 0.1); }
}
