surface t() {
    if (s > 0.5) Ci = 1; else if (t > 0.5) Ci = 0.5; else Ci = 0;
}
