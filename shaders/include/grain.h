// Noise of several octaves, and what stones and soils are made of.
#ifndef GRAIN_H
#define GRAIN_H

// How far apart neighbouring points are in a space, for `fade`.
float apart(point p) {
    return max(filterwidth(xcomp(p)), filterwidth(ycomp(p)), filterwidth(zcomp(p)));
}

// What is seen of a pattern of some size where points are so far apart: all where they resolve it, nothing but its mean where not.
float fade(float wide, size) {
    return 1 - smoothstep(0.35, 0.9, wide / size);
}

// How wide a pixel is at a point of a surface, along its longer side, in world units; i is the way from the eye. It asks for no points
// around, so that of stones those alone are shaded that are seen.
float pixelwidth(vector i; normal n) {
    // Pixels of a unit across, at two depths: parallel rays have as many at both.
    uniform point a = point(0, 0, 1), b = point(0.001, 0, 1), c = point(0, 0, 2), d = point(0.001, 0, 2);
    uniform float near = 1000 * distance(transform("camera", "raster", a), transform("camera", "raster", b));
    uniform float far = 1000 * distance(transform("camera", "raster", c), transform("camera", "raster", d));
    float depth = mix(1, length(i), clamp(2 - 2 * far / near, 0, 1));
    return depth / (near * max(0.05, abs(normalize(n) . normalize(i))));
}

// How long a unit of the world is in object space, which may be scaled.
float objectunit() {
    return length(vtransform("world", "object", vector(1, 0, 0)));
}

// Octaves of noise of which those that are too fine to be seen have faded.
float fading_octaves(point p; float n; float wide) {
    float sum = 0, size = 1, i;
    for (i = 0; i < n; i += 1) {
        sum += size * fade(wide, size) * (noise(p / size) - 0.5);
        size *= 0.5;
    }
    return sum;
}

// Sum of octaves of noise about 0, each half as strong and twice as fine.
float octaves(point p; float n) {
    float sum = 0, size = 1, i;
    for (i = 0; i < n; i += 1) {
        sum += size * (noise(p / size) - 0.5);
        size *= 0.5;
    }
    return sum;
}

// Ridges where octaves cross their middle.
float ridges(point p; float n) {
    float sum = 0, size = 1, i;
    for (i = 0; i < n; i += 1) {
        sum += size * (0.5 - abs(2 * noise(p / size) - 1));
        size *= 0.5;
    }
    return sum;
}

// Heights of the unevenness at a place, in parts of its size: what is too fine to be seen has faded.
float unevenness(float x, y, wide) {
    float broad = fade(wide, 1), fine = fade(wide, 0.3), sum = 0.5;
    if (broad > 0)
        sum += 0.4 * broad * (noise(x, y) - 0.5);
    if (fine > 0)
        sum += 0.2 * fine * (noise(3.3 * x + 7.3, 3.3 * y) - 0.5);
    float finer = fade(wide, 0.1), finest = fade(wide, 0.035);
    if (finer > 0)
        sum += 0.07 * finer * (noise(9.7 * x + 1.9, 9.7 * y + 4.1) - 0.5);
    if (finest > 0)
        sum += 0.032 * finest * (noise(31 * x, 31 * y + 8.7) - 0.5);
    return sum;
}

// How unevenness tilts a surface in the plane of world x and y, for its normal: bump says how steep.
vector tilt(float x, y, wide, bump) {
    float e = max(0.006, 0.5 * wide);
    float h = unevenness(x, y, wide);
    float hx = unevenness(x + e, y, wide) - h, hy = unevenness(x, y + e, wide) - h;
    return bump / e * (vector "world" (1, 0, 0) * hx + vector "world" (0, 1, 0) * hy);
}

#endif
