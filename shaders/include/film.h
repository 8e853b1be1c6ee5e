// How film answers to light.
#ifndef FILM_H
#define FILM_H

// From the light of a scene to that of a screen, 0 to 1, of a channel: with a toe, where shadows become black, and a shoulder towards white.
float film_curve(float light; uniform float white) {
    uniform float toe = 0.012;
    uniform float raised = 1 + toe / 0.18;
    uniform float top = raised * white * white / (white + toe);
    uniform float w = (top * (1.38 * top + 0.62) + 0.16) / (top * (1.45 * top + 0.05));
    float c = light * raised * light / (light + toe);
    return w * c * (1.45 * c + 0.05) / (c * (1.38 * c + 0.62) + 0.16);
}

// The same of each channel of a colour.
color film_curves(color light; uniform float white) {
    uniform float toe = 0.012;
    uniform float raised = 1 + toe / 0.18;
    uniform float top = raised * white * white / (white + toe);
    uniform float w = (top * (1.38 * top + 0.62) + 0.16) / (top * (1.45 * top + 0.05));
    color c = light * raised * light / (light + toe);
    return w * c * (1.45 * c + 0.05) / (c * (1.38 * c + 0.62) + 0.16);
}

// The same; colours that are too bright for a screen pale as they do on film. white: the light that becomes white; black: how
// much of the dark becomes black.
color filmic(color light; uniform float white, black) {
    // They run over to the others.
    float most = max(comp(light, 0), comp(light, 1), comp(light, 2));
    color c = max(mix(light, color(most, most, most), smoothstep(0.6, max(2 * white, 1.9), most)), color(0, 0, 0));
    // Channel by channel, colours become more vivid, and most so in the dark; by brightness alone, they stay as they are. Between the two.
    color vivid = film_curves(c, white);
    float bright = 0.3 * comp(c, 0) + 0.55 * comp(c, 1) + 0.15 * comp(c, 2);
    color plain = c * (film_curve(bright, white) / max(bright, 0.00001));
    c = min(mix(plain, vivid, 0.3), color(1, 1, 1));
    // A print's black is a little above that of the film, nearly as the eye sees steps of grey: in the root; what is brighter is left alone.
    color root = sqrt(c);
    color rest = (color(1, 1, 1) - root) * (color(1, 1, 1) - root);
    color seen = max(root - black * rest * rest, color(0, 0, 0));
    return seen * seen;
}

#endif
