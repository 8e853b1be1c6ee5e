surface t() {
    float r[2]; textureinfo("a.tx", "resolution", r); Ci = r[0];
}
