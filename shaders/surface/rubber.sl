// Rubber: nearly black, with a broad dull sheen; of a cylinder the tyre, with lugs, of a wheel with spokes. rim: radius of the wheel in
// the tyre's, 0 for none; lugs: around.
#include "edges.h"
surface rubber(float Ka = 1; float Kd = 0.9; float Ks = 0.12; float dust = 0.15; color tint = color(0.045, 0.045, 0.048); float rim = 0.62; float lugs = 24;
               color metal = color(0.5, 0.51, 0.53); float bevel = 0.15;) {
    float spread = 0;
    normal Nf = faceforward(rounded(normalize(N), I, bevel, spread), I);
    vector V = -normalize(I);
    float up = max(0, zcomp(ntransform("world", Nf)));
    point q = transform("shape", P);
    color c = mix(tint, color(0.4, 0.35, 0.28), dust * up * noise(12 * transform("object", P)));
    float shine = Ks;
    uniform float kind = shape_kind();
    if (kind == 2) {
        float r = sqrt(xcomp(q) * xcomp(q) + ycomp(q) * ycomp(q));
        float turn = atan(ycomp(q), xcomp(q)) / (2 * PI);
        if (abs(zcomp(q)) > 0.999 && r < rim) {
            // Five spokes between a hub and the rim, in a dark disc.
            float spoke = abs(mod(5 * turn, 1) - 0.5) * r;
            float metallic = r < 0.3 * rim || r > 0.86 * rim || spoke < 0.07 ? 1 : 0;
            c = metallic * metal + (1 - metallic) * 0.4 * tint;
            shine = 0.15 + 0.5 * metallic;
        } else if (r > 0.93 && lugs > 0) {
            // Lugs across the mantle, over the shoulders.
            float lug = abs(mod(lugs * turn + 0.5 * zcomp(q) * sign(zcomp(q)), 1) - 0.5);
            c *= 0.45 + 0.9 * smoothstep(0.18, 0.24, lug);
        }
    }
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + shine * gloss(Nf, V, 0.3, spread));
}
