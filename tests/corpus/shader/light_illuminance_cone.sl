surface t() {
    illuminance(P, N, 1.2) { Ci += Cl; }
}
