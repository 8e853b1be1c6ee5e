// How film answers to light.
#ifndef FILM_H
#define FILM_H

// From the light of a scene to that of a screen, 0 to 1: straight in the shadows, with a shoulder towards white, where colours pale
// as they do on film. white: the light that becomes white.
color filmic(color light; float white) {
    // Colours that are too bright for a screen run over to the others.
    float most = max(comp(light, 0), comp(light, 1), comp(light, 2));
    color c = mix(light, color(most, most, most), smoothstep(0.6, 2 * white, most));
    color one = c * (1.45 * c + 0.05) / (c * (1.38 * c + 0.62) + 0.16);
    float w = white * (1.45 * white + 0.05) / (white * (1.38 * white + 0.62) + 0.16);
    return clamp(one / w, color(0, 0, 0), color(1, 1, 1));
}

#endif
