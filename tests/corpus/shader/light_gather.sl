surface t() {
    float d; gather("illuminance", P, N, PI / 2, 8, "ray:length", d) { Ci += 1; } else { Ci += 0.1; }
}
