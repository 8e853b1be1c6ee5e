surface t() {
    Ci = xcomp(vtransform("shader", I));
}
