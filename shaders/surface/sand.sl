// Dry sand: fine grains of several tints, a few of them glinting.
#include "grain.h"
surface sand(float Ka = 1; float Kd = 0.9; float grain = 0.002; float ripples = 0.15; color tint = color(0.82, 0.7, 0.5);) {
    normal Nf = faceforward(normalize(N), I);
    point q = transform("object", P);
    // Grains that are too small to be seen are their mean, so that they do not glitter far away.
    float wide = apart(q);
    color one = mix(color(0.5, 0.5, 0.5), color cellnoise(q / grain), fade(wide, grain));
    float speck = cellnoise(q / (2.3 * grain));
    float soft = fading_octaves(q / (40 * grain), 4, wide / (40 * grain));
    color c = tint * (0.75 + 0.35 * comp(one, 0) + ripples * soft) * mix(color(1, 1, 1), one, 0.12);
    float glint = mix(0.015, speck > 0.985 ? 1 : 0, fade(wide, 2.3 * grain));
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + 0.4 * glint * specular(Nf, -normalize(I), 0.15));
}
