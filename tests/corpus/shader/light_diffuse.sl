surface t() {
    Ci = Cs * diffuse(faceforward(normalize(N), I));
}
