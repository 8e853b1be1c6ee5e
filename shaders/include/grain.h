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

#endif
