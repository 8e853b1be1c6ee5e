surface t() {
    bake3d("x.bkm", "Ci", P, N); Ci = 1;
}
