// A broken stone, cut from a sphere or an ellipsoid by planes that differ from stone to stone (id): it stays within that, and turns with it. depth:
// of the deepest cut, in radii; rounding: how much edges are worn, 0 sharp to 0.5 a pebble; slab: 0 as deep everywhere, 1 flat along the
// stone's own z; grain: height of the grain, in radii; warp: how uneven the faces are.
#include "grain.h"

// A plane across a direction: how far out of it the point is, 1 where the plane goes through the sphere; turn tells its depth, and how worn
// its edges are. Few cuts are deep.
#define CUT(x, y, z, turn) \
    deep = mod(seed * turn, 1); \
    out = own . (vector(x, y, z) / max(0.2, 1 - depth * (0.2 + 0.8 * deep) * (1 + slab * z * z))); \
    worn = rounding * (0.35 + 1.5 * mod(7 * deep, 1)); \
    near = max(0, worn - abs(most - out)); \
    most = max(most, out) + 0.25 * near * near / max(worn, 0.001);

displacement stone(float depth = 0.3; float rounding = 0.15; float slab = 0; float grain = 0.09; float warp = 0.45; uniform float id = 0;) {
    point Q = transform("shape", P);
    float R = length(Q);
    vector d = vector(Q) / R;
    uniform float first = 2 * PI * mod(id * 0.618034, 1), lean = PI * mod(id * 0.754878, 1);
    uniform vector a = vector(cos(first), sin(first), 0), c = vector(-sin(first) * sin(lean), cos(first) * sin(lean), cos(lean));
    uniform vector shift = 17 * vector(mod(id * 0.31, 1), mod(id * 0.47, 1), mod(id * 0.73, 1));
    // What is smaller than some pixels is left out.
    float pixels = length(vtransform("shape", "current", vector(Q))) / pixelwidth(I, normal(I));
    // No face is flat, and no edge straight.
    vector bent = d;
    float uneven = warp * smoothstep(1.5, 4, pixels), crooked = 0.45 * warp * smoothstep(6, 12, pixels);
    if (uneven > 0)
        bent += uneven * (vector noise(1.9 * d + shift) - vector(0.5, 0.5, 0.5));
    if (crooked > 0)
        bent += crooked * (vector noise(4.7 * d + shift) - vector(0.5, 0.5, 0.5));
    bent = normalize(bent);
    vector own = vector(bent . a, bent . (c ^ a), bent . c);
    uniform float seed = id + 3.7;
    float most = 1, out, near, worn, deep;
    // Fifteen directions, evenly spread, which each stone has turned its own way.
    CUT(0.36756, 0.00000, 0.93, 0.569840)
    CUT(-0.44242, 0.40529, 0.80, 0.984054)
    CUT(0.06490, -0.73952, 0.67, 1.398268)
    CUT(0.51596, 0.67297, 0.53, 1.812482)
    CUT(-0.90250, -0.15964, 0.40, 2.226696)
    CUT(0.81242, -0.51680, 0.27, 2.640910)
    CUT(-0.25740, 0.95752, 0.13, 3.055124)
    CUT(-0.46091, -0.88745, 0.00, 3.469338)
    CUT(0.93135, 0.34013, -0.13, 3.883552)
    CUT(-0.89001, 0.36739, -0.27, 4.297766)
    CUT(0.38846, -0.83012, -0.40, 4.711980)
    CUT(0.25379, 0.80913, -0.53, 5.126194)
    CUT(-0.64230, -0.37222, -0.67, 5.540408)
    CUT(0.58601, -0.12883, -0.80, 5.954622)
    CUT(-0.21139, 0.30069, -0.93, 6.368836)
    float rough = 0;
    if (grain > 0) {
        float lumps = smoothstep(2, 6, pixels), middle = smoothstep(6, 14, pixels), fine = smoothstep(18, 40, pixels), finest = smoothstep(60, 120, pixels);
        if (lumps > 0)
            rough += 0.6 * lumps * noise(3.1 * d + shift);
        if (middle > 0)
            rough += 0.45 * middle * abs(2 * noise(6.3 * d + shift) - 1);
        if (fine > 0)
            rough += 0.2 * fine * noise(17 * d + shift);
        if (finest > 0)
            rough += 0.1 * finest * noise(43 * d + shift);
    }
    // Stones are longer than they are broad.
    uniform float flat = 1.16 + 0.2 * mod(id * 0.37, 1), broad = 1 + 0.16 * mod(id * 0.91, 1);
    float longish = sqrt(xcomp(own) * xcomp(own) + broad * broad * ycomp(own) * ycomp(own) + flat * flat * zcomp(own) * zcomp(own));
    P = transform("shape", "current", point(d * (R * clamp(min(1, 1 / most) / longish - grain * rough, max(0.3, 1 - 1.16 * depth * (1 + slab)), 1))));
    N = calculatenormal(P);
}
