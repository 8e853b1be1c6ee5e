surface t() {
    float k = 0; opposite("Kd", k); Ci = k;
}
