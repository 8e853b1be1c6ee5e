surface t() {
    float kr, kt; vector r, q; fresnel(normalize(I), normalize(N), 0.66, kr, kt, r, q); Ci = kr * xcomp(r) + kt * xcomp(q);
}
