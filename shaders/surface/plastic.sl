// A coloured body under a clear, glossy skin. bevel: width of rounded edges of boxes and cylinders, in parts of their least half length;
// marks: how strong the marks of cylinders are, by which their turning is seen.
#include "edges.h"
surface plastic(float Ka = 1; float Kd = 0.5; float Ks = 0.5; float roughness = 0.025; color specularcolor = 1; float bevel = 0.06; float marks = 0.96;
                uniform float id = 0;) {
    float spread = 0;
    vector lean = 0;
    float mark = marks * marked(I, normalize(N), lean);
    normal Nf = faceforward(normalize(rounded(normalize(N), I, bevel, spread) + min(1, 2 * marks) * normal(lean)), I);
    color around = ambient();
    vector V = -normalize(I);
    color body = Cs * own_tone(id) * (1 - mark);
    Oi = Os;
    // Narrow highlights are as much brighter. What is seen through mirrors as much as what is not.
    Ci = Os * body * (Ka * around + Kd * diffuse(Nf))
         + specularcolor * Ks * ((1 / roughness + 8) / 36 * gloss(Nf, V, roughness, spread) + 2 * Ka * mirrors(Nf, V) * around);
}
