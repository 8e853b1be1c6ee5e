surface t() {
    Ci = 1 - occlusion(P, normalize(N), 16);
}
