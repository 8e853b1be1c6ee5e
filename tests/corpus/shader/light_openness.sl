// How much of the sky's light gets to a point.
surface light_openness() {
    vector parts = openness(P, faceforward(normalize(N), I), vector "world" (0, 0, 1));
    Ci = Cs * color(xcomp(parts), ycomp(parts), zcomp(parts));
    Oi = Os;
}
