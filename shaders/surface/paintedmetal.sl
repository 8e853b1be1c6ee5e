// Painted metal, worn to the bare steel in patches and at the edges of boxes and cylinders, with rust about what is bare. bevel: width of
// the edges, in parts of the least half length; marks: how strong the marks of cylinders are, by which their turning is seen.
#include "edges.h"
surface paintedmetal(float Ka = 1; float Kd = 0.9; float Ks = 0.8; float roughness = 0.015; float wear = 0.3; float size = 0.2;
                     color steel = color(0.55, 0.56, 0.58); color rust = color(0.35, 0.16, 0.07); float bevel = 0.1; float marks = 0.96;
                     uniform float id = 0;) {
    normal face = normalize(N);
    float spread = 0;
    normal turned = rounded(face, I, bevel, spread);
    normal Nf = faceforward(turned, I);
    vector V = -normalize(I);
    point o = transform("object", P);
    // Patches have one size on every body, however its object space is scaled.
    point q = point(xcomp(o) * length(vtransform("object", "current", vector (1, 0, 0))), ycomp(o) * length(vtransform("object", "current", vector (0, 1, 0))),
                    zcomp(o) * length(vtransform("object", "current", vector (0, 0, 1)))) / size + vector(17 * mod(id * 0.618034, 1), 0, 0);
    float edge = 1 - (turned . face);
    float worn = fading_octaves(q * 2, 5, 2 * pixelwidth(I, N) / size) + 0.9 * (wear - 0.55) + 1.3 * wear * smoothstep(0.02, 0.25, edge);
    float bare = smoothstep(0.02, 0.05, worn);
    float rusty = smoothstep(-0.05, 0.02, worn) * (1 - bare);
    color paint = Cs * own_tone(id) * (1 - marks * marked());
    color base = mix(mix(paint, rust, 0.7 * rusty), steel, bare);
    float shine = mix(Ks * (1 - rusty), 0.9, bare);
    color around = ambient();
    Oi = Os;
    Ci = Os * (base * (Ka * around + Kd * (1 - 0.5 * bare) * diffuse(Nf))
               + mix(color(1, 1, 1), steel, bare) * shine * (gloss(Nf, V, mix(roughness, 0.22, bare), spread) + 2 * Ka * mirrors(Nf, V) * around));
}
