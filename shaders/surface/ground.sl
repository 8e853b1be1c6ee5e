// A floor of fine sand with a faint metre grid, for scale. spacing: m between lines; line: their width, m, 0 for none.
#include "grain.h"
surface ground(float Ka = 1; float Kd = 0.9; float spacing = 1; float line = 0.008; float contrast = 0.22;) {
    point Q = transform("world", P);
    // What is too fine to be seen fades to its mean.
    float wide = apart(Q);
    float fine = fade(wide, 1 / 55) * (noise(Q * 55) - 0.5);
    float broad = fade(wide, 1 / 2.3) * (noise(Q * 2.3) - 0.5);
    color sand = Cs * (1 + 0.16 * fine + 0.12 * broad);
    if (line > 0) {
        float x = abs(mod(xcomp(Q) / spacing + 0.5, 1) - 0.5) * spacing;
        float y = abs(mod(ycomp(Q) / spacing + 0.5, 1) - 0.5) * spacing;
        // Lines keep at least a pixel's width, and fade with it, so that they do not break up far away.
        float pixel = max(0.0001, sqrt(area(P)));
        float width = max(line, pixel);
        float on = 1 - smoothstep(0.5 * width, 0.5 * width + pixel, min(x, y));
        sand = sand * (1 - contrast * on * line / width);
    }
    normal Nf = faceforward(normalize(N), I);
    Oi = Os;
    Ci = Os * sand * (Ka * ambient() + Kd * diffuse(Nf));
}
