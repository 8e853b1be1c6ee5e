surface t() {
    float k = 0; if (displacement("Km", k) == 1) Ci = k;
}
