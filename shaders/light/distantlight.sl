// The sun: parallel light, with shadows unless shadowname is "". With an angle, degrees, it is a disc in the sky, and its shadows
// are soft: by `samples` rays where it is half hidden.
#include "disc.h"
light distantlight(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0); point to = point "shader" (0, 0, 1);
                   string shadowname = "raytrace"; float angle = 0; float samples = 16;) {
    vector way = normalize(to - from);
    solar(way, 0) {
        Cl = intensity * lightcolor;
        if (shadowname != "")
            Cl *= through_disc(Ps, -way, angle, angle > 0 ? samples : 1);
    }
}
