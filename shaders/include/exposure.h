// What an imager gets and gives: colours that are exposed, (gain · c)^(1/gamma), as Exposure says (RISpec 4.1.2). With Option "imager"
// "float exposed" [0] it gets light, and gives colours that are exposed all the same.
#ifndef EXPOSURE_H
#define EXPOSURE_H

// To a power, whatever the sign.
color signed_power(color c; float exponent) {
    return sign(c) * pow(abs(c), color(exponent, exponent, exponent));
}

// The light that was exposed to this.
color unexposed(color c) {
    uniform float exposure[2] = {1, 1};
    option("Exposure", exposure);
    uniform float is_exposed = 1;
    option("imager:exposed", is_exposed);
    color light = c;
    if (is_exposed != 0) {
        light = exposure[1] == 1 ? c : signed_power(c, exposure[1]);
        light = exposure[0] == 0 ? light : light / exposure[0];
    }
    return light;
}

// Light, exposed.
color exposed(color light) {
    uniform float exposure[2] = {1, 1};
    option("Exposure", exposure);
    color c = light * exposure[0];
    return exposure[1] == 1 ? c : signed_power(c, 1 / exposure[1]);
}

#endif
