surface t() {
    Ci = texture3d("x.bkm", P, N);
}
