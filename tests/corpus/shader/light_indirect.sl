surface t() {
    Ci = indirectdiffuse(P, normalize(N), 16, "maxdist", 10);
}
