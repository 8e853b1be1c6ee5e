// Brushed steel: streaks along s, and a highlight drawn out across them.
surface steel(float Ka = 1; float Kd = 0.25; float Ks = 0.9; float streaks = 400; color tint = color(0.6, 0.61, 0.63);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    point q = transform("object", P);
    float streak = noise(zcomp(q) * streaks, 0.7 * xcomp(q)) * 0.6 + noise(zcomp(q) * streaks * 3.1) * 0.4;
    vector along = normalize(vtransform("object", "current", vector(0, 0, 1)) ^ vector Nf);
    color spread = 0;
    illuminance(P, Nf, PI / 2) {
        vector H = normalize(normalize(L) + V);
        float ct = along . H;
        float cn = max(0, Nf . H);
        spread += Cl * pow(max(0, 1 - ct * ct), 6) * pow(cn, 14);
    }
    Oi = Os;
    Ci = Os * Cs * tint * (Ka * ambient() + Kd * diffuse(Nf) + Ks * (0.7 + 0.5 * (streak - 0.5)) * spread);
}
