surface t() {
    Ci = ctransform("hsv", Cs) + ctransform("hsv", "rgb", Cs);
}
