// Arrows and trails: their colour as it is on the image, whatever light, exposure and film make of the rest, a little darker where it turns away.
surface mark(float shade = 0.4; output varying color displaycolor = 0; output varying color displaycover = 0;) {
    float facing = abs(normalize(N) . normalize(I));
    displaycolor = Cs * (1 - shade * (1 - facing));
    displaycover = 1;
    Oi = Os;
    Ci = Os * displaycolor;
}
