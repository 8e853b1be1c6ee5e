// Edges and marks of boxes and cylinders: metadata says which they are by Attribute "shape" "float kind", 1 for a box, 2 for a cylinder
// about z, both of unit size in the space "shape".
#ifndef EDGES_H
#define EDGES_H
#include "grain.h"

float shape_kind() {
    float kind = 0;
    float found = attribute("shape:kind", kind);
    return found == 1 ? kind : 0;
}

// How much a face leans to another that is so far away: half at the edge.
float leaning(float away, width) {
    return 1 - clamp(away / width, 0, 1);
}

// The normal as of edges that are rounded over a width, in parts of the shape's least half length. Edges narrower than a pixel turn it as
// much less, but not to nothing; spread is how much the normals of a pixel vary, for `gloss`.
normal rounded(normal n; vector i; float width; output float spread;) {
    normal turned = n;
    uniform float kind = shape_kind();
    spread = 0;
    if (kind > 0 && width > 0) {
        point q = transform("shape", P);
        vector ax = vtransform("shape", "current", vector(1, 0, 0)), ay = vtransform("shape", "current", vector(0, 1, 0));
        vector az = vtransform("shape", "current", vector(0, 0, 1));
        float lx = length(ax), ly = length(ay), lz = length(az);
        float own = width * min(lx, ly, lz), pixel = pixelwidth(i, n);
        float w = max(own, 1.3 * pixel);
        // An edge keeps its light far away, where it is but a pixel, until the shape itself is some pixels.
        float share = mix(own / w, 1, 0.9 * smoothstep(3, 9, own / width / pixel));
        vector over = az / lz * sign(zcomp(q)) * leaning((1 - abs(zcomp(q))) * lz, w);
        if (kind == 1) {
            over += ax / lx * sign(xcomp(q)) * leaning((1 - abs(xcomp(q))) * lx, w);
            over += ay / ly * sign(ycomp(q)) * leaning((1 - abs(ycomp(q))) * ly, w);
        } else {
            float r = max(0.0001, sqrt(xcomp(q) * xcomp(q) + ycomp(q) * ycomp(q)));
            over += (ax / lx * xcomp(q) + ay / ly * ycomp(q)) / r * leaning((1 - r) * lx, w);
        }
        turned = normalize(n + normal(share * over));
        vector aside = over - n * (over . n);
        // An eighth of a turn over the width, and where that is narrower than a pixel, the rest of the pixel is flat.
        spread = min(1, 3 * length(aside)) * share * (0.05 * min(pixel / w, 1.25) * min(pixel / w, 1.25) + 0.1 * (1 - share));
    }
    return turned;
}

// A highlight of a glossy skin whose normals vary within the pixel: wider, and as much weaker (after Toksvig).
color gloss(normal n; vector v; float roughness, spread) {
    float wider = roughness + spread;
    return (1 / wider + 8) / (1 / roughness + 8) * specular(n, v, wider);
}

// How much a glossy skin mirrors, by the angle: Schlick's form of Fresnel's, of paint and plastic, whose skin is
// too rough to mirror all at a slant.
float mirrors(normal n; vector v;) {
    float low = 1 - clamp(n . v, 0, 1);
    return 0.04 + 0.4 * low * low * low * low * low;
}

// How much of a pixel is within a distance that is negative inside.
float within(float out, pixel) {
    return 1 - smoothstep(-0.7, 0.7, out / max(pixel, 0.00001));
}

// How dark the marks of a cylinder are, by which its turning is seen: in the ends holes about a bore, one of them filled and a line to it,
// and lines along the mantle. i is the way from the eye, n the face. Marks that are too small to be seen fade to their mean. lean is how the
// rims of holes and grooves turn the normal.
float marked(vector i; normal n; output vector lean;) {
    float on = 0;
    lean = 0;
    uniform float kind = shape_kind();
    if (kind == 2) {
        point q = transform("shape", P);
        float lx = length(vtransform("shape", "current", vector(1, 0, 0))), lz = length(vtransform("shape", "current", vector(0, 0, 1)));
        float pixel = pixelwidth(i, n) / lx, x = xcomp(q), y = ycomp(q);
        float r = sqrt(x * x + y * y), turn = atan(y, x) / (2 * PI);
        if (abs(zcomp(q)) > 0.999) {
            // The nearest of six places for holes, about its middle; the way of the eye, in radii.
            vector way = vtransform("shape", i);
            way = vector(xcomp(way), ycomp(way), zcomp(way) * lz / lx);
            float place = floor(6 * turn + 0.5), hole = 0.145, deep = min(0.3, 0.8 * lz / lx);
            float hx = 0.58 * cos(place * PI / 3), hy = 0.58 * sin(place * PI / 3);
            if (r < 0.36) {
                hx = 0;
                hy = 0;
                hole = 0.13;
            }
            float u = x - hx, v = y - hy;
            float out = sqrt(u * u + v * v) - hole;
            float is_filled = place == 0 && r >= 0.36 ? 1 : 0;
            // Through the mouth of a hole its bottom is seen, or its wall, which is darker the deeper.
            float far = deep / max(0.05, abs(zcomp(way)));
            float bx = u + far * xcomp(way), by = v + far * ycomp(way);
            float missed = sqrt(bx * bx + by * by) / hole;
            float dark = mix(0.97, 0.5, smoothstep(1, 3, missed));
            on = within(out, pixel) * (is_filled > 0 ? 1 : dark);
            // Grooves about the boss and within the rim; a line from the boss to the filled place.
            float ring = abs(r - 0.3) < abs(r - 0.84) ? r - 0.3 : r - 0.84;
            on = max(on, 0.55 * within(abs(ring) - 0.008, pixel));
            vector ax = vtransform("shape", "current", vector(1, 0, 0)) / lx, ay = vtransform("shape", "current", vector(0, 1, 0)) / lx;
            float rim = max(0.03, 1.2 * pixel), seen = fade(pixel, 0.1);
            float turned = is_filled > 0 ? 0 : -seen * leaning(abs(out), rim) / (out + hole + 0.001);
            float dented = -0.6 * seen * leaning(abs(ring), rim) * sign(ring) / (r + 0.001);
            lean = (ax * u + ay * v) * turned + (ax * x + ay * y) * dented;
            float line = max(abs(y) - 0.022, abs(x - 0.57) - 0.27);
            on = max(on, within(line, pixel));
        } else {
            // Four lines along the mantle, one of them broad; in the mean a tenth of it.
            float about = abs(mod(4 * turn + 0.5, 1) - 0.5) / 4;
            float half = abs(turn) < 0.1 ? 0.02 : 0.008;
            on = within(2 * PI * (about - half) * max(r, 0.001), pixel) * 0.8;
        }
        on = mix(0.1, on, fade(pixel, 0.35));
    }
    return on;
}

// A step of tone that tells alike boxes and cylinders apart that touch, by their ids.
float own_tone(float id) {
    uniform float kind = shape_kind();
    return kind > 0 ? 1 + 0.14 * (mod(id * 0.618034, 1) - 0.5) : 1;
}

#endif
