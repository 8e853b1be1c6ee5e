surface t() {
    Ci = area(P, "dicing");
}
