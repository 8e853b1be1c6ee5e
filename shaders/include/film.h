// How film answers to light.
#ifndef FILM_H
#define FILM_H

// From the light of a scene to that of a screen, 0 to 1, of a channel or of each channel of a colour: with a toe, where shadows become black,
// and a shoulder towards white.
#define FILM_CURVE(kind, name) \
    kind name(kind light; uniform float white) { \
        uniform float toe = 0.012; \
        uniform float raised = 1 + toe / 0.18; \
        uniform float top = raised * white * white / (white + toe); \
        uniform float w = (top * (1.38 * top + 0.62) + 0.16) / (top * (1.45 * top + 0.05)); \
        kind c = light * raised * light / (light + toe); \
        return w * c * (1.45 * c + 0.05) / (c * (1.38 * c + 0.62) + 0.16); \
    }
FILM_CURVE(float, film_curve)
FILM_CURVE(color, film_curves)

// From light to that of a screen; colours that are too bright for a screen pale as they do on film. white: the light that becomes white; black: how
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

// Levels as of Option "film" "levels", for brightness as it is on a screen: what is `low` becomes 0.04, nearly black, and what is `high` 0.95,
// nearly white; a line from black to 1, below it a toe, and what is in its upper part lifted the more the brighter it is. In roots of
// light, `dark` and `bright` are low and high, `black` and `white` what they become.
#define LEVEL(kind, name) \
    kind name(kind x; uniform float dark, bright, black, white) { \
        uniform float slope = (1 - black) / (1 - dark), toe = slope * dark / black; \
        uniform float high = black + slope * (bright - dark), from = 0.6 * high, lift = white - high; \
        uniform float shoulder = (1 + 2 * lift / (high - from)) * (1 - high) / (1 - white); \
        kind one = 1, none = 0, top = high, t = min(x / dark, one); \
        kind y = black * t / (t + toe * (1 - t)) + slope * clamp(x - dark, none, one); \
        kind q = clamp((y - from) / (high - from), none, one), u = clamp((1 - y) / (1 - high), none, one); \
        return min(y, top) + lift * q * q + (1 - white) * (1 - u / (u + shoulder * (1 - u))); \
    }
LEVEL(float, level)
LEVEL(color, levels)

// The light of a screen, with the levels that the scene's option gives. Half channel by channel, which is vivid, half by brightness alone.
color levelled(color light) {
    uniform float given[2] = {0.04, 0.95};
    option("film:levels", given);
    color c = light;
    if (given[0] != 0.04 || given[1] != 0.95) {
        uniform float dark = pow(given[0], 1.1), bright = pow(given[1], 1.1), black = pow(0.04, 1.1), white = pow(0.95, 1.1);
        color root = sqrt(clamp(c, color(0, 0, 0), color(1, 1, 1)));
        float y = 0.2126 * comp(root, 0) + 0.7152 * comp(root, 1) + 0.0722 * comp(root, 2);
        color plain = root * (level(y, dark, bright, black, white) / max(y, 0.00001));
        root = min(mix(plain, levels(root, dark, bright, black, white), 0.5), color(1, 1, 1));
        c = root * root;
    }
    return c;
}

#endif
