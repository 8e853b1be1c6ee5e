surface t() {
    float c[2]; option("Clipping", c); Ci = c[0];
}
