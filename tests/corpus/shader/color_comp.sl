surface t() {
    color c = Cs; setcomp(c, 0, 0.5); Ci = comp(c, 0) + comp(c, 2);
}
