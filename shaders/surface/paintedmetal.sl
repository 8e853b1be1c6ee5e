// Painted metal, worn to the bare steel in patches, with rust at their edges.
#include "grain.h"
surface paintedmetal(float Ka = 1; float Kd = 0.7; float Ks = 0.35; float roughness = 0.12; float wear = 0.3; float size = 0.2;
                     color steel = color(0.55, 0.56, 0.58); color rust = color(0.35, 0.16, 0.07);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    point q = transform("object", P) / size;
    float worn = octaves(q * 2, 6) + 0.9 * (wear - 0.5);
    float bare = smoothstep(0.02, 0.04, worn);
    float edge = smoothstep(-0.04, 0.02, worn) * (1 - bare);
    color base = mix(mix(Cs, rust, edge), steel, bare);
    float shine = mix(Ks * (1 - edge), 0.9, bare);
    Oi = Os;
    Ci = Os * (base * (Ka * ambient() + Kd * (1 - 0.5 * bare) * diffuse(Nf))
               + mix(color(1, 1, 1), steel, bare) * shine * specular(Nf, V, mix(roughness, 0.22, bare)));
}
