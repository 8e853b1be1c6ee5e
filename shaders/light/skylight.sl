// Light from the whole sky, and what the ground sends back of sun and sky: soft, and less where bodies are in the way. open 0: as if
// nothing were in the way, for drafts; contact: how much deeper than measured the shadows in gaps are, 1 for as measured; bounce: how much
// of the light what is in the way sends on.
#include "sky.h"
light skylight(float intensity = 1; vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; color lightcolor = 1; color ground = color(0.3, 0.27, 0.23); float open = quality_of_sky(); float contact = 2; float bounce = 0.25;
               color zenith = sky_share() * sky_color(vector(0, 0, 1), suns_way(sun), turbidity_of(turbidity));
               color horizon = sky_share() * horizon_color(suns_way(sun), turbidity_of(turbidity));
               color beneath = ground * (suns_color(suns_way(sun), turbidity_of(turbidity)) * max(0, zcomp(suns_way(sun))) + 0.5 * (zenith + horizon));) {
    vector up = vector "world" (0, 0, 1);
    vector parts;
    float sent = 0;
    if (open != 0) {
        parts = openness(Ps, Ns, up);
        // What is in the way is lit itself, the less the deeper the gap that it makes.
        float free = clamp(xcomp(parts) + zcomp(parts), 0, 1);
        sent = 0.5 * bounce * (1 - free) * free;
        // Gaps are deeper than measured, but what is under a roof is no hole: light comes in from around.
        parts *= pow(mix(0.35, 1, free), contact - 1);
    } else {
        float above = 0.5 + 0.5 * zcomp(normalize(Ns));
        parts = vector(above, 2 / 3 * pow(above, 1.65), 1 - above);
    }
    // What is around a point that sees little of the sky is as dark as it.
    float dim = clamp(0.08 + xcomp(parts) + 0.6 * zcomp(parts), 0, 1);
    Cl = intensity * lightcolor * (horizon * xcomp(parts) + (zenith - horizon) * ycomp(parts) + beneath * zcomp(parts) * dim + (horizon + beneath) * sent);
}
