// A colour behind everything, from bottom to top, and the film that takes the picture of the rest: exposure, a filmic curve.
#include "exposure.h"
#include "film.h"
imager film(color bgcolor = 0; color top = color(-1, -1, -1); float exposure = 1; float white = 4; float black = 0.13; float film = 1;) {
    uniform float format[3] = {640, 480, 1};
    option("Format", format);
    uniform float on = film;
    option("film:view", on);
    Ci = exposure * unexposed(Ci);
    // What covers a part of a pixel does so on the screen.
    if (on != 0 && alpha > 0)
        Ci = alpha * filmic(Ci / alpha, white, black);
    Ci += (1 - alpha) * mix(comp(top, 0) < 0 ? bgcolor : top, bgcolor, smoothstep(0, 1, ycomp(P) / format[1]));
    if (on != 0)
        Ci = levelled(Ci);
    Ci = exposed(Ci);
    Oi = 1;
    alpha = 1;
}
