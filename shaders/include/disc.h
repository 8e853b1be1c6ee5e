// The shadow of a light that is a disc in the sky.
#ifndef DISC_H
#define DISC_H

// How much of a disc a point sees, towards a direction, of an angle in degrees. Two rays, to wide discs five, say whether the point is in
// the half-shadow at all; there the disc has `samples` of them, along a spiral that is turned from point to point.
color through_disc(point p; vector way; uniform float angle, samples) {
    color lit;
    if (samples > 1) {
        vector across = normalize(abs(xcomp(way)) < 0.7 ? vector (1, 0, 0) ^ way : vector (0, 1, 0) ^ way);
        vector up = way ^ across;
        uniform float radius = tan(radians(angle / 2)), probes = angle > 2 ? 5 : 2, i;
        float turn = 2 * PI * float cellnoise(8192 * p);
        color first = 0, light = 0;
        float differ = 0;
        for (i = 0; i < probes; i += 1) {
            float a = turn + i * 2 * PI / probes;
            light = transmission(p, p + 100000 * (way + (probes > 2 ? 0.95 : 0.75) * radius * (cos(a) * across + sin(a) * up)));
            if (i == 0)
                first = light;
            else if (light != first)
                differ = 1;
        }
        lit = first;
        if (differ > 0) {
            lit = 0;
            for (i = 0; i < samples; i += 1) {
                float r = radius * sqrt((i + 0.5) / samples);
                float a = turn + i * 2.399963;
                lit += transmission(p, p + 100000 * (way + r * (cos(a) * across + sin(a) * up)));
            }
            lit /= samples;
        }
    } else {
        lit = transmission(p, p + 100000 * way);
    }
    return lit;
}

#endif
