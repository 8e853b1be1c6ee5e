surface t() {
    Ci = noise(P, time);
}
