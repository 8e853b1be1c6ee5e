// Crushed stone: speckled and veined in the stone's own space, so that the pattern turns with it.
// skylight: how much less ambient light faces get that are turned down, for scenes whose ambient light does not know.
// size: the grain of the pattern, in the unit of the stone's space; variation: how much stones and spots differ.
#include "grain.h"
surface gravel(float Ka = 1; float Kd = 0.9; float size = 0.02; float variation = 0.35; float skylight = 0; uniform float id = 0;) {
    point Q = transform("object", P) / size + 31 * vector(mod(id * 0.618034, 1), mod(id * 0.754878, 1), mod(id * 0.56984, 1));
    // What is too fine to be seen fades to its mean: of veins a third.
    float wide = pixelwidth(I, N) * objectunit() / size;
    float broad = fade(wide, 1 / 0.35), middle = fade(wide, 1 / 2.1), veined = fade(wide, 0.3 / 0.18), fine = fade(wide, 1 / 5.3);
    float mottle = 0.5, speckle = 0.5, vein = 0.32, dust = 0.5;
    if (broad > 0)
        mottle = mix(0.5, noise(Q * 0.35), broad);
    if (middle > 0)
        speckle = mix(0.5, noise(Q * 2.1), middle);
    if (veined > 0)
        vein = mix(0.32, 1 - smoothstep(0.0, 0.12, abs(noise(Q * 0.18 + point(31.4, 0, 0)) - 0.5)), veined);
    if (fine > 0)
        dust = mix(0.5, noise(Q * 5.3 + vector(3.1, 0, 0)), fine);
    float tone = 1 + variation * ((mottle - 0.5) * 1.3 + (speckle - 0.5) * 0.8 + (dust - 0.5) * 0.7) + 0.16 * variation * (vein - 0.32);
    color stone = Cs * clamp(tone, 0.25, 1.8);
    normal Nf = faceforward(normalize(N), I);
    // The sky is brighter than the ground, so that faces turned up take more of the ambient light.
    float sky = mix(1, 0.5 + 0.5 * zcomp(Nf), skylight);
    Oi = Os;
    Ci = Os * stone * (Ka * sky * ambient() + Kd * diffuse(Nf));
}
