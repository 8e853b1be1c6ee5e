surface t() {
    Ci = Du(s) * du + Dv(s) * dv;
}
