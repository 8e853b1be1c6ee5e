// The sun in the sky that the scene's Option "sky" names: its colour is that of its height and the haze, its shadows are those of a disc
// of half a degree, by `samples` rays where it is half hidden; with samples 1 they are sharp.
#include "sky.h"
#include "disc.h"
light sunlight(float intensity = 1; vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; color lightcolor = 1; float angle = 0.53; float samples = quality_of_sun();
               vector way = suns_way(sun); color tint = suns_color(way, turbidity_of(turbidity));) {
    solar(-way, 0) {
        Cl = intensity * lightcolor * tint * through_disc(Ps, way, angle, samples);
    }
}
