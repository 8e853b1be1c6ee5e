// How film answers to light.
#ifndef FILM_H
#define FILM_H

// From the light of a scene to that of a screen, 0 to 1: with a toe, where shadows become black, and a shoulder towards white, where
// colours pale as they do on film. white: the light that becomes white.
color filmic(color light; uniform float white) {
    uniform float toe = 0.08;
    uniform float raised = 1 + toe / 0.18;
    uniform float top = raised * white * white / (white + toe);
    uniform float w = (top * (1.38 * top + 0.62) + 0.16) / (top * (1.45 * top + 0.05));
    // Colours that are too bright for a screen run over to the others.
    float most = max(comp(light, 0), comp(light, 1), comp(light, 2));
    color c = max(mix(light, color(most, most, most), smoothstep(0.6, 2 * white, most)), color(0, 0, 0));
    c *= raised * c / (c + toe);
    c = min(w * c * (1.45 * c + 0.05) / (c * (1.38 * c + 0.62) + 0.16), color(1, 1, 1));
    // A print's black is a little above that of the film, nearly as the eye sees steps of grey: in the root.
    uniform float black = 0.027;
    color seen = max(color(sqrt(comp(c, 0)), sqrt(comp(c, 1)), sqrt(comp(c, 2))) - color(black, black, black), color(0, 0, 0)) / (1 - black);
    return seen * seen;
}

#endif
