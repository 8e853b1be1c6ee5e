surface t() {
    Ci = smoothstep(0.2, 0.8, s);
}
