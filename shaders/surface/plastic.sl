// A coloured body under a clear, glossy skin. bevel: width of rounded edges of boxes and cylinders, in parts of their least half length;
// marks: how strong the marks of cylinders are, by which their turning is seen.
#include "edges.h"
surface plastic(float Ka = 1; float Kd = 0.5; float Ks = 0.5; float roughness = 0.1; color specularcolor = 1; float bevel = 0.06; float marks = 0.9;
                uniform float id = 0;) {
    float spread = 0;
    normal Nf = faceforward(rounded(normalize(N), I, bevel, spread), I);
    color around = ambient();
    vector V = -normalize(I);
    color body = Cs * own_tone(id) * (1 - marks * marked(I, normalize(N)));
    Oi = Os;
    Ci = Os * (body * (Ka * around + Kd * diffuse(Nf)) + specularcolor * Ks * (gloss(Nf, V, roughness, spread) + 2 * Ka * mirrors(Nf, V) * around));
}
