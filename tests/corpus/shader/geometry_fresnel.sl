surface t() {
    float kr, kt; fresnel(normalize(I), normalize(N), 0.66, kr, kt); Ci = kr + kt;
}
