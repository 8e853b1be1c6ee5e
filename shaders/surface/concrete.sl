// Cast concrete: pale, blotched, with small pores.
#include "grain.h"
surface concrete(float Ka = 1; float Kd = 0.9; float size = 0.1;) {
    // Object space may be scaled to the block: its axes' lengths make the pattern the same size on every block.
    point Q = transform("object", P);
    float x = xcomp(Q) * length(vtransform("object", "current", vector (1, 0, 0)));
    float y = ycomp(Q) * length(vtransform("object", "current", vector (0, 1, 0)));
    float z = zcomp(Q) * length(vtransform("object", "current", vector (0, 0, 1)));
    Q = point (x, y, z) / size;
    // What is too fine to be seen fades to its mean: of pores one part in twelve.
    float wide = apart(Q);
    float blotch = mix(0.5, noise(Q * 0.6), fade(wide, 1 / 0.6)) * 0.6 + mix(0.5, noise(Q * 2.3), fade(wide, 1 / 2.3)) * 0.4;
    float pores = mix(0.04, smoothstep(0.68, 0.78, noise(Q * 9)), fade(wide, 1 / 9));
    color tone = Cs * (0.82 + 0.36 * (blotch - 0.2)) * (1 - 0.35 * pores);
    normal Nf = faceforward(normalize(N), I);
    Oi = Os;
    Ci = Os * tone * (Ka * (0.7 + 0.3 * zcomp(Nf)) * ambient() + Kd * diffuse(Nf));
}
