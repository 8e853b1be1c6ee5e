// Brushed steel: streaks along s, and a highlight drawn out across them. bevel: width of rounded edges of boxes and cylinders, in parts of
// their least half length; marks: how strong the marks of cylinders are, by which their turning is seen.
#include "edges.h"
surface steel(float Ka = 1; float Kd = 0.25; float Ks = 0.9; float streaks = 400; color tint = color(0.6, 0.61, 0.63); float bevel = 0.04; float marks = 0.96;) {
    float bent = 0;
    vector lean = 0;
    float mark = marks * marked(I, normalize(N), lean);
    normal Nf = faceforward(normalize(rounded(normalize(N), I, bevel, bent) + min(1, 2 * marks) * normal(lean)), I);
    vector V = -normalize(I);
    point q = transform("object", P);
    // What is too fine to be seen fades to its mean.
    float wide = pixelwidth(I, N) * objectunit() * streaks;
    float streak = mix(0.5, noise(zcomp(q) * streaks, 0.7 * xcomp(q)), fade(wide, 1)) * 0.6
                   + mix(0.5, float noise(zcomp(q) * streaks * 3.1), fade(wide, 0.32)) * 0.4;
    vector along = normalize(vtransform("object", "current", vector(0, 0, 1)) ^ vector Nf);
    color spread = 0;
    illuminance(P, Nf, PI / 2) {
        vector H = normalize(normalize(L) + V);
        float ct = along . H;
        float cn = max(0, Nf . H);
        spread += Cl * pow(max(0, 1 - ct * ct), 6) * pow(cn, 14);
    }
    Oi = Os;
    Ci = Os * Cs * tint * (1 - mark) * (0.85 + 0.3 * streak) * (Ka * ambient() + Kd * diffuse(Nf) + Ks * (0.7 + 0.5 * (streak - 0.5)) * spread);
}
