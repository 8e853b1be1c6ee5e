surface t() {
    float k = 0; surface("Kd", k); Ci = k;
}
