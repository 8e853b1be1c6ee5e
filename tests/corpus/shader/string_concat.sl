surface t(string name = "gravel";) {
    Ci = concat("a", "b", "c") == "abc" ? 1 : 0;
}
