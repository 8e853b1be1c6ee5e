surface t() {
    float r = 1; attribute("ShadingRate", r); Ci = r;
}
