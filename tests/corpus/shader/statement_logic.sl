surface t() {
    if ((s > 0.2 && t > 0.2) || !(s < 0.9)) Ci = 1;
}
