// Edges and marks of boxes and cylinders: metadata says which they are by Attribute "shape" "float kind", 1 for a box, 2 for a cylinder
// about z, both of unit size in object space.
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
// much less; spread is how much the normals of a pixel vary, for `gloss`.
normal rounded(normal n; vector i; float width; output float spread;) {
    normal turned = n;
    uniform float kind = shape_kind();
    spread = 0;
    if (kind > 0 && width > 0) {
        point q = transform("object", P);
        vector ax = vtransform("object", "current", vector(1, 0, 0)), ay = vtransform("object", "current", vector(0, 1, 0));
        vector az = vtransform("object", "current", vector(0, 0, 1));
        float lx = length(ax), ly = length(ay), lz = length(az);
        float own = width * min(lx, ly, lz), pixel = pixelwidth(i, n);
        float w = max(own, 0.8 * pixel);
        float share = own / w;
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

// 1 on the marks of a cylinder, by which its turning is seen: two quarters of a disc on its ends, and bars across its mantle.
float marked() {
    float on = 0;
    uniform float kind = shape_kind();
    if (kind == 2) {
        point q = transform("object", P);
        float r = sqrt(xcomp(q) * xcomp(q) + ycomp(q) * ycomp(q));
        if (abs(zcomp(q)) > 0.999)
            on = r < 0.42 && xcomp(q) * ycomp(q) > 0 ? 1 : 0;
        else if (abs(zcomp(q)) > 0.8)
            on = mod(atan(ycomp(q), xcomp(q)) / (PI / 2) + 0.06, 1) < 0.12 ? 1 : 0;
    }
    return on;
}

// A step of tone that tells alike boxes and cylinders apart that touch, by their ids.
float own_tone(float id) {
    uniform float kind = shape_kind();
    return kind > 0 ? 1 + 0.14 * (mod(id * 0.618034, 1) - 0.5) : 1;
}

#endif
