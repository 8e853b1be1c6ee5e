surface t() {
    Ci = ambient();
}
