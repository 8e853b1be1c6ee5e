surface t(string name = "gravel";) {
    Ci = match("^gra", name);
}
