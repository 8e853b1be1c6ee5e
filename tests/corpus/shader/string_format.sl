surface t(string name = "gravel";) {
    Ci = format("%f %d %s %p %c", s, 3, "x", P, Cs) == "" ? 0 : 1;
}
