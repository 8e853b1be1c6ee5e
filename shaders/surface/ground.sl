// Dry soil with detail at every distance, pebbles, and, if wanted, a grid for scale. size: m, of the largest unevenness; bump: how steep it is;
// stones: how many of the places for pebbles have one, 0 to 1; pebble: m between these places; spacing: m between lines; line: their width,
// m, 0 for none.
#include "grain.h"

surface ground(float Ka = 1; float Kd = 0.9; float spacing = 1; float line = 0; float contrast = 0.22; float size = 0.35; float bump = 0.05;
               float stones = 0.06; float pebble = 0.06;) {
    // Lengths are those of the space in which the shader stands.
    point Q = transform("shader", P);
    float wide = pixelwidth(I, N) * length(vtransform("shader", vector "world" (1, 0, 0)));
    float x = xcomp(Q), y = ycomp(Q);
    normal Nf = faceforward(normalize(N), I);
    // Patches of paler and darker soil, of several sizes, that fade into their mean.
    float wash = 0.16 * fade(wide, 9 * size) * (noise(x / (9 * size) + 3.7, y / (9 * size)) - 0.5)
                 + 0.22 * fade(wide, 31 * size) * (noise(x / (31 * size) + 11.2, y / (23 * size)) - 0.5)
                 + 0.14 * fade(wide, 2.7 * size) * (noise(x / (2.7 * size) + 5.1, y / (2.1 * size)) - 0.5);
    color soil = Cs * (1 + wash) * mix(color(1, 1, 1), color(1.06, 0.99, 0.9), clamp(6 * wash, -1, 1));
    vector slope = 0;
    float near = wide / size;
    if (near < 0.9) {
        slope = tilt(x / size, y / size, near, bump);
    }
    // Of what is seen at a slant the pixels are long, but their other side tells grains apart.
    float across = wide * sqrt(max(0.05, abs(normalize(N) . normalize(I))));
    float middle = fade(across, 0.09), fine = fade(across, 0.02), grains = fade(across, 0.009);
    if (middle > 0)
        soil *= 1 + 0.2 * middle * (noise(x * 13, y * 13) - 0.5);
    if (fine > 0)
        soil *= 1 + 0.28 * fine * (noise(x * 55, y * 55) - 0.5);
    if (grains > 0)
        soil *= 1 + 0.36 * grains * (noise(x * 140, y * 140) - 0.5);
    // A pebble in some of the cells of a grid, with a place, a size and a turn of its own. Near by they would be discs.
    float shown = fade(wide, 0.7 * pebble) * (1 - smoothstep(18, 36, pebble / wide));
    if (shown > 0) {
        float cx = floor(x / pebble) + 0.5, cy = floor(y / pebble) + 0.5;
        if (cellnoise(cx, cy) < stones) {
            color own = cellnoise(cx + 37, cy);
            float r = 0.09 + 0.16 * comp(own, 2) * comp(own, 2), room = 1.3 * r, turn = 40 * comp(own, 2);
            float dx = (x / pebble - cx + 0.5 - mix(room, 1 - room, comp(own, 0))) / r;
            float dy = (y / pebble - cy + 0.5 - mix(room, 1 - room, comp(own, 1))) / r;
            float along = dx * cos(turn) + dy * sin(turn), across = 1.5 * (dy * cos(turn) - dx * sin(turn));
            float out = sqrt(along * along + across * across) + 0.35 * (noise(2.5 * dx + turn, 2.5 * dy) - 0.5);
            float on = shown * (1 - smoothstep(0.8, 1.1, out));
            soil = mix(soil, Cs * (0.5 + 0.5 * mod(7 * comp(own, 0), 1)), on);
            slope = mix(slope, -0.5 * (vector "world" (1, 0, 0) * dx + vector "world" (0, 1, 0) * dy), on);
        }
    }
    Nf = normalize(Nf - slope);
    if (line > 0) {
        float lx = abs(mod(x / spacing + 0.5, 1) - 0.5) * spacing;
        float ly = abs(mod(y / spacing + 0.5, 1) - 0.5) * spacing;
        // Lines keep at least a pixel's width, and fade with it, so that they do not break up far away.
        float pixel = max(0.0001, wide);
        float width = max(line, pixel);
        float on = 1 - smoothstep(0.5 * width, 0.5 * width + pixel, min(lx, ly));
        soil = soil * (1 - contrast * on * line / width);
    }
    Oi = Os;
    Ci = Os * soil * (Ka * ambient() + Kd * diffuse(Nf));
}
