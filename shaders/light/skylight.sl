// Light from the whole sky, and what the ground and the bodies around send on of sun and sky: soft, and less where bodies are in the way.
// open 0: as if nothing were in the way, for drafts; bounce: how much of the light what is in the way sends on, in its own colour;
// sunshine: the sun's light that falls on it.
#include "sky.h"
light skylight(float intensity = 1; vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; color lightcolor = 1; color ground = color(0.3, 0.27, 0.23); float open = quality_of_sky(); float bounce = 1; vector way = suns_way(sun);
               color zenith = sky_share() * sky_color(vector(0, 0, 1), suns_way(sun), turbidity_of(turbidity));
               color horizon = sky_share() * horizon_color(suns_way(sun), turbidity_of(turbidity));
               color beneath = ground * (suns_color(suns_way(sun), turbidity_of(turbidity)) * max(0, zcomp(suns_way(sun))) + 0.5 * (zenith + horizon));
               color sunshine = suns_color(way, turbidity_of(turbidity));) {
    vector up = vector "world" (0, 0, 1);
    if (open != 0) {
        matrix around = surroundings(Ps, Ns, up, way);
        color light = horizon * comp(around, 0, 0) + (zenith - horizon) * comp(around, 0, 1) + beneath * comp(around, 0, 2);
        color sent = bounce * color(comp(around, 1, 0), comp(around, 1, 1), comp(around, 1, 2));
        // What is in the way is lit by the sun, and as much by the sky as what it hides: again and again, a geometric series.
        float closed = comp(around, 0, 3);
        color again = color(1, 1, 1) / (color(1, 1, 1) - sent * closed);
        light = (light + sent * sunshine * comp(around, 1, 3)) * again;
        // Cones are wider than the deepest gaps.
        float free = 1 - closed;
        light *= 1.06 * free / (free + 0.06);
        // Nothing is black: some light comes in by many ways.
        Cl = intensity * lightcolor * (light + 0.02 * closed * sent * (horizon + 0.4 * sunshine) * again);
    } else {
        float above = 0.5 + 0.5 * zcomp(normalize(Ns));
        Cl = intensity * lightcolor * (horizon * above + (zenith - horizon) * 2 / 3 * pow(above, 1.65) + beneath * (1 - above));
    }
}
