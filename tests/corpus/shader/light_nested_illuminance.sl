surface t() {
    illuminance(P) { color c = Cl; illuminance(P, N, 1) { c += Cl; } Ci += c; }
}
