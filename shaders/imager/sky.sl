// The sky behind everything, and the film that takes the picture: exposure, a filmic curve. As the scene's Option "sky" says. hills: the height
// of a range of hills in the haze of the horizon, degrees, 0 for none.
#include "exposure.h"
#include "sky.h"
#include "film.h"
imager sky(vector sun = vector(0.5, 0.4, 0.7); float turbidity = 3; float exposure = 1; float white = 4; float black = 0.13; float film = 1; color ground = color(0.3, 0.27, 0.23);
           float disc = 1; float hills = 0; vector way = suns_way(sun); float haziness = turbidity_of(turbidity); color sunshine = suns_color(suns_way(sun), turbidity_of(turbidity));
           color lit = ground * (suns_color(suns_way(sun), turbidity_of(turbidity)) * max(0, zcomp(suns_way(sun)))
                                 + sky_color(vector(0, 0, 1), suns_way(sun), turbidity_of(turbidity)));) {
    Ci = unexposed(Ci);
    if (alpha < 1) {
        uniform point eye = transform("camera", "world", point(0, 0, 0));
        vector look = normalize(transform("raster", "world", P) - eye);
        // Parallel rays all go one way: then the sky is that of a lens.
        uniform point a = point(0, 0, 1), b = point(0.001, 0, 1), c = point(0, 0, 2), d = point(0.001, 0, 2);
        uniform float near = distance(transform("camera", "raster", a), transform("camera", "raster", b));
        uniform float far = distance(transform("camera", "raster", c), transform("camera", "raster", d));
        if (far > 0.99 * near) {
            uniform float format[3] = {640, 480, 1};
            option("Format", format);
            uniform float least = min(format[0], format[1]);
            look = normalize(vtransform("camera", "world", vector((2 * xcomp(P) - format[0]) / least, (format[1] - 2 * ycomp(P)) / least, 3.2)));
        }
        float high = zcomp(look);
        color behind = seen_share() * sky_color(vector(xcomp(look), ycomp(look), max(0.02, high)), way, haziness);
        if (hills > 0 && high < radians(hills) * 1.6 + 0.001) {
            // Three ranges, the nearer ones lower and less in haze; how high they are depends on the direction alone.
            float x = xcomp(look) / max(0.001, sqrt(1 - high * high)), y = ycomp(look) / max(0.001, sqrt(1 - high * high));
            float side = 0.5 + 0.5 * (x * xcomp(way) + y * ycomp(way)) / max(0.001, sqrt(1 - zcomp(way) * zcomp(way)));
            color haze = mix(haze_color(way, haziness, -1), haze_color(way, haziness, 1), side * side * side);
            float range;
            for (range = 0; range < 3; range += 1) {
                float shift = 7 + 20 * range, rough = 3 + 1.5 * range;
                float h = 0.66 * noise(rough * x + shift, rough * y) + 0.24 * noise(3.7 * rough * x, 3.7 * rough * y + shift)
                          + 0.1 * noise(11 * rough * x, 11 * rough * y + shift);
                float top = radians(hills) * (1.3 - 0.4 * range) * max(0, 2.1 * h - 0.6);
                if (high < top + 0.0008) {
                    // Slopes, a little paler where they turn to the sun; towards the foot there is more haze.
                    float fine = 9 * rough, step = (x * ycomp(way) - y * xcomp(way)) * 0.6;
                    point q = point(fine * x + shift, fine * y, 90 * high);
                    float relief = noise(q) - noise(q + vector(-y * step, x * step, 0.3)) + 0.5 * (noise(2.3 * q) - noise(2.3 * q + vector(-y * step, x * step, 0.3)));
                    float deep = clamp((top - high) / radians(hills), 0, 1);
                    color rock = 0.5 * lit * clamp(0.8 + 0.5 * relief, 0.5, 1.2);
                    behind = mix(mix(haze, rock, (0.14 + 0.12 * range) * (1 - 0.75 * deep)), behind, smoothstep(-0.0008, 0.0008, high - top));
                }
            }
        }
        // Below the horizon there is far ground in haze.
        behind = mix(behind, lit, smoothstep(0, 0.25, -high));
        float off = degrees(acos(clamp(look . way, -1, 1)));
        behind += disc * sunshine * 30 * (1 - smoothstep(0.26, 0.34, off)) * smoothstep(-0.002, 0.002, high);
        Ci += (1 - alpha) * behind;
    }
    Oi = 1;
    alpha = 1;
    uniform float on = film;
    option("film:view", on);
    Ci *= exposure;
    if (on != 0)
        Ci = levelled(filmic(Ci, white, black));
    Ci = exposed(Ci);
}
