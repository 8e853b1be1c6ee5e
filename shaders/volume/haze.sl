// Haze before what is far, of the colour that the sky has at the horizon there. distance: m after which a third of the light is left.
#include "sky.h"
volume haze(float distance = 2000; vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; float start = 0;
            vector way = suns_way(sun); color towards = haze_color(suns_way(sun), turbidity_of(turbidity), 1);
            color away = haze_color(suns_way(sun), turbidity_of(turbidity), -1);) {
    float far = length(vtransform("shader", I));
    float d = 1 - exp(-max(0, far - start) / distance);
    // How far the way turns to the sun, seen from above; most of the sky's horizon is as it is opposite to it.
    float level = sqrt((xcomp(I) * xcomp(I) + ycomp(I) * ycomp(I)) * (xcomp(way) * xcomp(way) + ycomp(way) * ycomp(way)));
    float side = 0.5 + 0.5 * (xcomp(I) * xcomp(way) + ycomp(I) * ycomp(way)) / max(level, 0.000001);
    Ci = mix(Ci, mix(away, towards, side * side * side), d);
}
