surface t() {
    illuminance("key", P, N, PI / 2) { Ci += Cl; }
}
