surface t() {
    Ci = ptlined(point(0,0,0), point(1,0,0), P);
}
