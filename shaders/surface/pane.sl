// A pane of coloured glass, thin and even: it holds back what Os says, shows a sheen of its own colour, and mirrors sky and sun, most at its
// rounded edges, which gather light. bevel: their width, in parts of the least half length.
#include "edges.h"
surface pane(float Ka = 0.15; float Kd = 0.35; float Ks = 0.8; float roughness = 0.03; float bevel = 0.5;) {
    float spread = 0;
    normal face = normalize(N);
    normal turned = rounded(face, I, bevel, spread);
    normal Nf = faceforward(turned, I);
    vector V = -normalize(I);
    float edge = smoothstep(0.02, 0.2, 1 - (turned . face));
    color around = ambient();
    Oi = mix(Os, color(1, 1, 1), 0.35 * edge);
    Ci = Oi * Cs * (mix(Ka, 0.8, edge) * around + mix(Kd, 0.7, edge) * diffuse(Nf)) + Ks * (gloss(Nf, V, roughness, spread) + 0.3 * mirrors(Nf, V) * around);
}
