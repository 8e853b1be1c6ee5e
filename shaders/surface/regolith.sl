// Lunar soil: dark and grey, brightest where the light comes from behind the eye (Lommel and Seeliger). grain: m, size of its crumbs;
// bump: how steep its unevenness is.
#include "grain.h"
surface regolith(float Ka = 1; float Kd = 1.6; float grain = 0.01; color tint = color(0.36, 0.35, 0.33); float bump = 0.12;) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    point q = transform("object", P), w = transform("shader", P);
    float wide = pixelwidth(I, N), own = wide * objectunit();
    float shade = 0.9 + 0.3 * fading_octaves(q / (20 * grain), 3, own / (20 * grain));
    shade += 0.4 * fading_octaves(q / (2 * grain) + vector(7.7, 1.3, 4.9), 3, own / (2 * grain));
    float size = 30 * grain;
    wide *= length(vtransform("shader", vector "world" (1, 0, 0)));
    if (wide < 0.9 * size)
        Nf = normalize(Nf - tilt(xcomp(w) / size, ycomp(w) / size, wide / size, bump));
    color sum = Ka * ambient();
    illuminance(P, Nf, PI / 2) {
        float mu0 = max(0, Nf . normalize(L));
        float mu = max(0.05, Nf . V);
        sum += Kd * Cl * mu0 / (mu0 + mu);
    }
    Oi = Os;
    Ci = Os * Cs * tint * shade * sum;
}
