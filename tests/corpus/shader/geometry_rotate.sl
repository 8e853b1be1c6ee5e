surface t() {
    Ci = xcomp(rotate(P, 0.5, point(0,0,0), point(0,0,1)));
}
