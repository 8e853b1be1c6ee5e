// A broken stone, cut from a sphere by planes that differ from stone to stone (id): it stays within the sphere, and turns with it. depth:
// of the deepest cut, in radii; rounding: how much edges are worn, 0 sharp to 0.5 a pebble; slab: 0 as deep everywhere, 1 flat along the
// stone's own z; grain: height of the grain, in radii.
#include "grain.h"

// A plane across a direction: how far out of it the point is, 1 where the plane goes through the sphere; turn tells its depth.
#define CUT(x, y, z, turn) \
    out = own . (vector(x, y, z) / max(0.2, 1 - depth * (0.3 + 0.7 * mod(seed * turn, 1)) * (1 + slab * z * z))); \
    near = max(0, rounding - abs(most - out)); \
    most = max(most, out) + near * near * blend;

displacement stone(float depth = 0.3; float rounding = 0.045; float slab = 0; float grain = 0.04; uniform float id = 0;) {
    point Q = transform("object", P);
    float R = length(Q);
    vector d = vector(Q) / R;
    uniform float first = 2 * PI * mod(id * 0.618034, 1), lean = PI * mod(id * 0.754878, 1);
    uniform vector a = vector(cos(first), sin(first), 0), c = vector(-sin(first) * sin(lean), cos(first) * sin(lean), cos(lean));
    vector own = vector(d . a, d . (c ^ a), d . c);
    uniform float seed = id + 3.7;
    float blend = 0.25 / max(rounding, 0.001), most = 1, out, near;
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
    // The grain is seen where a fifth of the radius is more than a pixel.
    float pixels = length(vtransform("object", "current", vector(Q))) / pixelwidth(I, normal(I));
    float rough = 0, shown = grain * smoothstep(3, 9, pixels);
    if (shown > 0) {
        uniform vector shift = 17 * vector(mod(id * 0.31, 1), mod(id * 0.47, 1), mod(id * 0.73, 1));
        rough = shown * (noise(5 * d + shift) + 0.5 * noise(13 * d + shift));
    }
    P = transform("object", "current", point(d * (R * clamp(min(1, 1 / most) - rough, 0.3, 1))));
    N = calculatenormal(P);
}
