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

// The normal as of edges that are rounded over a width, in parts of the shape's least half length; never less than a pixel's, so that
// they catch light from afar, too.
normal rounded(normal n; vector i; float width) {
    normal turned = n;
    uniform float kind = shape_kind();
    if (kind > 0 && width > 0) {
        point q = transform("object", P);
        vector ax = vtransform("object", "current", vector(1, 0, 0)), ay = vtransform("object", "current", vector(0, 1, 0));
        vector az = vtransform("object", "current", vector(0, 0, 1));
        float lx = length(ax), ly = length(ay), lz = length(az);
        float w = max(width * min(lx, ly, lz), 0.8 * pixelwidth(i, n));
        vector over = az / lz * sign(zcomp(q)) * leaning((1 - abs(zcomp(q))) * lz, w);
        if (kind == 1) {
            over += ax / lx * sign(xcomp(q)) * leaning((1 - abs(xcomp(q))) * lx, w);
            over += ay / ly * sign(ycomp(q)) * leaning((1 - abs(ycomp(q))) * ly, w);
        } else {
            float r = max(0.0001, sqrt(xcomp(q) * xcomp(q) + ycomp(q) * ycomp(q)));
            over += (ax / lx * xcomp(q) + ay / ly * ycomp(q)) / r * leaning((1 - r) * lx, w);
        }
        turned = normalize(n + normal(over));
    }
    return turned;
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
