surface t() {
    float k = 0; incident("Kd", k); Ci = k;
}
