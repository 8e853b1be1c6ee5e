surface t() {
    Ci = xcomp(ntransform("camera", N));
}
