surface t(string name = "gravel";) {
    Ci = name == "gravel" ? 1 : 0;
}
