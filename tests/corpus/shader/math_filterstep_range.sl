surface t() {
    Ci = filterstep(0.5, s, s + 0.1, "filter", "box");
}
