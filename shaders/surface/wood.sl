// Sawn wood: rings about the object's x axis, with pores along it.
#include "grain.h"
surface wood(float Ka = 1; float Kd = 0.8; float Ks = 0.12; float ring = 0.02; color light = color(0.72, 0.5, 0.28);
             color dark = color(0.42, 0.25, 0.11);) {
    normal Nf = faceforward(normalize(N), I);
    point q = transform("object", P);
    point bent = q + vector(0, 1, 1) * (ring * 1.5 * octaves(q / (12 * ring) + vector(3, 1, 4), 3));
    float r = sqrt(ycomp(bent) * ycomp(bent) + zcomp(bent) * zcomp(bent)) / ring;
    float year = mod(r, 1);
    float late = smoothstep(0.35, 0.9, year) * (1 - smoothstep(0.92, 1, year));
    float pore = smoothstep(0.62, 0.75, noise(point(xcomp(q) / (8 * ring), ycomp(q) / (0.15 * ring), zcomp(q) / (0.15 * ring))));
    color c = mix(light, dark, 0.75 * late + 0.25 * pore);
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * specular(Nf, -normalize(I), 0.18));
}
