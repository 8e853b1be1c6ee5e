// A coat of dust over the primitive's own colour: thick where it faces up.
#include "grain.h"
surface dust(float Ka = 1; float Kd = 0.85; float Ks = 0.2; float cover = 0.7; color tint = color(0.66, 0.58, 0.46); float size = 0.05;) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    float up = zcomp(normalize(ntransform("world", Nf)));
    float lie = smoothstep(0.1, 0.9, up + 0.35 * fading_octaves(transform("object", P) / size, 4, pixelwidth(I, N) * objectunit() / size)) * cover;
    color c = mix(Cs, tint, lie);
    Oi = Os;
    Ci = Os * (c * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * (1 - lie) * specular(Nf, V, 0.15));
}
