// The sun in the sky that the scene's Option "sky" names: its colour is that of its height and the haze, its shadows are those of a disc
// of half a degree; with samples 1 they are sharp.
#include "sky.h"
light sunlight(float intensity = 1; vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; color lightcolor = 1; float angle = 0.53; float samples = quality_of_sun();
               vector way = suns_way(sun); color tint = suns_color(way, turbidity_of(turbidity));) {
    solar(-way, 0) {
        if (samples > 1) {
            vector across = normalize(abs(xcomp(way)) < 0.7 ? vector (1, 0, 0) ^ way : vector (0, 1, 0) ^ way);
            vector up = way ^ across;
            float turn = 2 * PI * float cellnoise(8192 * Ps);
            color lit = 0;
            uniform float i;
            for (i = 0; i < samples; i += 1) {
                float r = tan(radians(angle / 2)) * sqrt((i + 0.5) / samples);
                float a = turn + i * 2.399963;
                lit += transmission(Ps, Ps + 100000 * (way + r * (cos(a) * across + sin(a) * up)));
            }
            Cl = intensity * lightcolor * tint * lit / samples;
        } else {
            Cl = intensity * lightcolor * tint * transmission(Ps, Ps + 100000 * way);
        }
    }
}
