surface t() {
    illuminance(P) { Ci += Cl; }
}
