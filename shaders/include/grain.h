// Noise of several octaves, and what stones and soils are made of.
#ifndef GRAIN_H
#define GRAIN_H

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
