// Colour by a number that the primitive brings as `value`, between `low` and `high`; with `legend` 1 a surface shows the ramp along s.
#include "ramp.h"
surface byvalue(float Ka = 1; float Kd = 0.8; float Ks = 0.1; varying float value = 0; float low = 0, high = 1; float bands = 0; float legend = 0;) {
    normal Nf = faceforward(normalize(N), I);
    float x = legend != 0 ? s : (value - low) / (high - low);
    if (bands > 0)
        x = (floor(clamp(x, 0, 0.9999) * bands) + 0.5) / bands;
    color c = ramp(x);
    // The colours of a legend are those of the scale, whatever light there is.
    Oi = Os;
    Ci = legend != 0 ? Os * c : Os * (c * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * specular(Nf, -normalize(I), 0.15));
}
