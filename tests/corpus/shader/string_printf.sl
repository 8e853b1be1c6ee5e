surface t() {
    printf("%f\n", 1); Ci = 1;
}
