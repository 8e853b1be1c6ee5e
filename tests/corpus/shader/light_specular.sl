surface t() {
    Ci = specular(normalize(N), -normalize(I), 0.1);
}
