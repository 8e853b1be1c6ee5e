surface t() {
    float d = 0; atmosphere("distance", d); Ci = d;
}
