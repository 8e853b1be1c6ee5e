surface t() {
    string n = ""; attribute("user:name", n); Ci = n == "" ? 0 : 1;
}
