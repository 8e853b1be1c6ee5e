surface t() {
    float i = floor(s * 2.99); Ci = comp(Cs, i) + Cs[1];
}
