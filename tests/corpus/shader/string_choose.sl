surface t(string name = "gravel";) {
    Ci = (s > 0.5 ? name : "sand") == "sand" ? 1 : 0;
}
