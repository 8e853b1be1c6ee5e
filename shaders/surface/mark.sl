// Arrows and trails: flat colour, whatever the light, a little darker where it turns away.
surface mark(float shade = 0.4;) {
    float facing = abs(normalize(N) . normalize(I));
    Oi = Os;
    Ci = Os * Cs * (1 - shade * (1 - facing));
}
