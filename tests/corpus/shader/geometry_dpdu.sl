surface t() {
    Ci = length(dPdu) + length(dPdv);
}
