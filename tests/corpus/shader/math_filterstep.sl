surface t() {
    Ci = filterstep(0.5, s);
}
