surface t() {
    illuminance(P) { float k = 1; lightsource("intensity", k); Ci += k; }
}
