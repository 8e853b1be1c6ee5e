surface t(string name = "gravel";) {
    Ci = name != "sand" ? 1 : 0;
}
