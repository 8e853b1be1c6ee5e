surface t() {
    string n[2] = {"a", "b"}; float i = 1; Ci = n[i] == "b" ? 1 : 0;
}
