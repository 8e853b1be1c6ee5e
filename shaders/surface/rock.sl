// Broken rock: layers, cracks and a little lichen.
#include "grain.h"
surface rock(float Ka = 1; float Kd = 0.85; float Ks = 0.08; float size = 0.1; color dark = color(0.28, 0.26, 0.24);
             color light = color(0.62, 0.58, 0.53); float lichen = 0.3;) {
    normal Nf = faceforward(normalize(N), I);
    point q = transform("object", P) / size;
    // What is too fine to be seen fades to its mean.
    float wide = pixelwidth(I, N) * objectunit() / size;
    // Layers lie across z, where they are finer: a surface that lies as they do has them no finer than along x and y.
    float up = zcomp(normalize(ntransform("object", N)));
    float layer = fading_octaves(q * 2 + vector(0, 0, 3 * zcomp(q)), 5, wide * sqrt(4 + 21 * (1 - up * up)));
    float crack = smoothstep(0.0, 0.08, abs(fading_octaves(q * 1.7 + vector(5, 2, 9), 4, 1.7 * wide)));
    crack = mix(0.8, crack, fade(1.7 * wide, 0.3));
    color c = mix(dark, light, clamp(0.5 + layer, 0, 1)) * mix(0.45, 1, crack);
    float grown = smoothstep(0.12, 0.3, fading_octaves(q * 3 + vector(11, 7, 1), 4, 3 * wide));
    grown = mix(0.1, grown, fade(3 * wide, 0.5)) * lichen;
    c = mix(c, color(0.55, 0.6, 0.32), grown);
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * specular(Nf, -normalize(I), 0.25));
}
