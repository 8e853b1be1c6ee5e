// Painted metal: a coat that is a little uneven, scuffed at the edges of boxes and cylinders, and, with more wear, worn in patches to the
// bare steel, with rust about what is bare. wear: 0 new, from 0.4 on worn through; bevel: width of the edges, in parts of the least half
// length; marks: how strong the marks of cylinders are, by which their turning is seen.
#include "edges.h"
surface paintedmetal(float Ka = 1; float Kd = 0.9; float Ks = 1.6; float roughness = 0.02; float wear = 0.3; float size = 0.2;
                     color steel = color(0.55, 0.56, 0.58); color rust = color(0.2, 0.12, 0.08); float bevel = 0.1; float marks = 0.96;
                     uniform float id = 0;) {
    normal face = normalize(N);
    float spread = 0;
    normal turned = rounded(face, I, bevel, spread);
    vector lean = 0;
    float mark = marks * marked(I, face, lean);
    normal Nf = faceforward(normalize(turned + min(1, 2 * marks) * normal(lean)), I);
    vector V = -normalize(I);
    point o = transform("object", P);
    // Patches have one size on every body, however its object space is scaled.
    point q = point(xcomp(o) * length(vtransform("object", "current", vector (1, 0, 0))), ycomp(o) * length(vtransform("object", "current", vector (0, 1, 0))),
                    zcomp(o) * length(vtransform("object", "current", vector (0, 0, 1)))) / size + vector(17 * mod(id * 0.618034, 1), 0, 0);
    float edge = smoothstep(0.02, 0.25, 1 - (turned . face)), wide = pixelwidth(I, N) / size;
    float patchy = fading_octaves(q * 2, 5, 2 * wide);
    float worn = patchy + 0.9 * (wear - 0.95) + 0.3 * edge;
    float bare = smoothstep(0.02, 0.05, worn);
    float rusty = smoothstep(-0.05, 0.02, worn) * (1 - bare);
    // Dust lies in a thin film, less where the edges are rubbed: these are paler.
    float film = 0.06 * (0.5 + 1.2 * patchy) * (1 - edge);
    color paint = mix(Cs * own_tone(id) * (1 + 0.1 * patchy), color(0.3, 0.28, 0.25), clamp(film, 0, 1)) * (1 - mark);
    paint = mix(paint, 0.25 * steel + 0.8 * paint, min(1, 2.5 * wear) * edge);
    color base = mix(mix(paint, rust, 0.6 * rusty), steel, bare);
    float shine = mix(Ks * (1 - rusty) * (1 - 2 * film), 0.9, bare);
    color around = ambient();
    Oi = Os;
    // What is seen through mirrors as much as what is not.
    Ci = Os * base * (Ka * around + Kd * (1 - 0.5 * bare) * diffuse(Nf))
         + mix(color(1, 1, 1), steel, bare) * shine * (gloss(Nf, V, mix(roughness, 0.22, bare), spread) + 1.2 * Ka * mirrors(Nf, V) * around);
}
