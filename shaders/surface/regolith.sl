// Lunar soil: dark and grey, brightest where the light comes from behind the eye (Lommel and Seeliger).
#include "grain.h"
surface regolith(float Ka = 1; float Kd = 1.6; float grain = 0.01; color tint = color(0.36, 0.35, 0.33);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    point q = transform("object", P);
    float wide = apart(q);
    float shade = 0.85 + 0.5 * fading_octaves(q / (20 * grain), 5, wide / (20 * grain));
    shade += 0.15 * fade(wide, grain) * (cellnoise(q / grain) - 0.5);
    color sum = Ka * ambient();
    illuminance(P, Nf, PI / 2) {
        float mu0 = max(0, Nf . normalize(L));
        float mu = max(0.05, Nf . V);
        sum += Kd * Cl * mu0 / (mu0 + mu);
    }
    Oi = Os;
    Ci = Os * Cs * tint * shade * sum;
}
