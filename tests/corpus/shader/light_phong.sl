surface t() {
    Ci = phong(normalize(N), -normalize(I), 20);
}
