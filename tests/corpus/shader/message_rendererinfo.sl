surface t() {
    string n; rendererinfo("renderer", n); Ci = n == "scree" ? 1 : 0;
}
