surface t() {
    { float x = 1; Ci = x; } { float x = 2; Ci += x; }
}
