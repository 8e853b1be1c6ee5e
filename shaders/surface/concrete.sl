// Cast concrete: pale, blotched, with small pores and worn edges. bevel: width of these, in parts of a block's least half length.
#include "edges.h"
surface concrete(float Ka = 1; float Kd = 0.9; float size = 0.1; float bevel = 0.06; uniform float id = 0;) {
    // Object space may be scaled to the block: its axes' lengths make the pattern the same size on every block.
    point Q = transform("object", P);
    float x = xcomp(Q) * length(vtransform("object", "current", vector (1, 0, 0)));
    float y = ycomp(Q) * length(vtransform("object", "current", vector (0, 1, 0)));
    float z = zcomp(Q) * length(vtransform("object", "current", vector (0, 0, 1)));
    Q = point (x, y, z) / size + vector(17 * mod(id * 0.618034, 1), 0, 0);
    // What is too fine to be seen fades to its mean: of pores one part in fifty.
    float wide = pixelwidth(I, N) / size;
    float blotch = mix(0.5, noise(Q * 0.6), fade(wide, 1 / 0.6)) * 0.6 + mix(0.5, noise(Q * 2.3), fade(wide, 1 / 2.3)) * 0.4;
    float pores = mix(0.02, smoothstep(0.72, 0.82, noise(Q * 13)), fade(wide, 1 / 13));
    // Stains of several sizes, paler and darker, whose mean is that of their noise.
    float stain = mix(0.5, noise(Q * 0.17 + vector(3.1, 7.7, 1.3)), fade(wide, 1 / 0.17));
    color tone = Cs * own_tone(id) * (0.93 + 0.5 * (blotch - 0.5) + 0.5 * (stain - 0.5)) * (1 - 0.3 * pores);
    float spread = 0;
    normal Nf = faceforward(rounded(normalize(N), I, bevel, spread), I);
    Oi = Os;
    Ci = Os * tone * (Ka * ambient() + Kd * diffuse(Nf));
}
