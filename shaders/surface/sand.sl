// Dry sand: fine grains of several tints, a few of them glinting. bump: how steep its ripples are, of about 80 grains.
#include "grain.h"
surface sand(float Ka = 1; float Kd = 0.9; float grain = 0.002; float ripples = 0.15; color tint = color(0.82, 0.7, 0.5); float bump = 0.1;) {
    normal Nf = faceforward(normalize(N), I);
    point q = transform("object", P), w = transform("world", P);
    // Grains that are too small to be seen are their mean, so that they do not glitter far away.
    float wide = pixelwidth(I, N), own = wide * objectunit();
    color one = 0.5;
    if (fade(own, grain) > 0)
        one = mix(color(0.5, 0.5, 0.5), color cellnoise(q / grain), fade(own, grain));
    float speck = cellnoise(q / (2.3 * grain));
    float soft = fading_octaves(q / (40 * grain), 3, own / (40 * grain));
    color c = tint * (0.75 + 0.35 * comp(one, 0) + ripples * soft) * mix(color(1, 1, 1), one, 0.12);
    float glint = mix(0.015, speck > 0.985 ? 1 : 0, fade(own, 2.3 * grain));
    float size = 80 * grain;
    if (wide < 0.9 * size)
        Nf = normalize(Nf - tilt(xcomp(w) / size, ycomp(w) / size, wide / size, bump));
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + 0.4 * glint * specular(Nf, -normalize(I), 0.15));
}
