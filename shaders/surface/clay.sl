// Unfired clay: matt and soft, for shapes without a material yet (Oren and Nayar).
surface clay(float Ka = 1; float Kd = 0.95; float sigma = 0.5; color tint = color(0.72, 0.6, 0.52);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    float s2 = sigma * sigma;
    float A = 1 - 0.5 * s2 / (s2 + 0.33), B = 0.45 * s2 / (s2 + 0.09);
    float tv = acos(Nf . V);
    vector vp = normalize(V - vector Nf * (Nf . V));
    color sum = Ka * ambient();
    illuminance(P, Nf, PI / 2) {
        vector l = normalize(L);
        float tl = acos(Nf . l);
        vector lp = normalize(l - vector Nf * (Nf . l));
        sum += Kd * Cl * cos(tl) * (A + B * max(0, vp . lp) * sin(max(tl, tv)) * tan(min(min(tl, tv), 1.4)));
    }
    Oi = Os;
    Ci = Os * Cs * tint * sum;
}
