surface t() {
    float d; rayinfo("depth", d); Ci = d;
}
