// Colours for numbers from 0 to 1, dark to light: close to viridis (Smith and van der Walt, 2015).
#ifndef RAMP_H
#define RAMP_H
color ramp(float x) {
    return spline("linear", clamp(x, 0, 1), color(0.267, 0.005, 0.329), color(0.267, 0.005, 0.329), color(0.283, 0.141, 0.458),
                  color(0.254, 0.265, 0.530), color(0.207, 0.372, 0.553), color(0.164, 0.471, 0.558), color(0.128, 0.567, 0.551),
                  color(0.135, 0.659, 0.518), color(0.267, 0.749, 0.441), color(0.478, 0.821, 0.318), color(0.741, 0.873, 0.150),
                  color(0.993, 0.906, 0.144), color(0.993, 0.906, 0.144));
}
#endif
