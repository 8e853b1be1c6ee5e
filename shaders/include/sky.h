// The clear sky of the daylight model of Preetham, Shirley and Smits (1999), and the sun in it: colours as lights have them, of which 1
// is a sun of 100 000 lx. A scene says once where its sun is and how hazy the air is, Option "sky" "vector sun" [x y z] "float turbidity" [t];
// lights, imagers and volumes ask for both here, so that they agree.
#ifndef SKY_H
#define SKY_H

// The way to the sun, from where the scene says it is, or a sun of its own.
vector suns_way(vector own) {
    vector said = 0;
    vector way = own;
    if (option("sky:sun", said) == 1)
        way = said;
    return normalize(way);
}

// 2 is the clearest air, 10 is haze.
float turbidity_of(float own) {
    float said = 0;
    float t = own;
    if (option("sky:turbidity", said) == 1)
        t = said;
    return clamp(t, 1.8, 12);
}

// Whether what is in the way of the sky's light hides it, and how many samples the sun's disc has: as the quality of the image says.
float quality_of_sky() {
    float said = 1;
    float found = option("quality:sky", said);
    return found == 1 ? said : 1;
}

float quality_of_sun() {
    float said = 1;
    float found = option("quality:sun", said);
    return found == 1 ? said : 1;
}

// The sun's light after its way through the air: Rayleigh's and aerosols' scattering at three wavelengths.
color suns_color(vector way; float turbidity) {
    float high = max(0, zcomp(way));
    float mass = 1 / (high + 0.15 * pow(max(1, 93.885 - degrees(acos(high))), -1.253));
    float beta = 0.04608 * turbidity - 0.04586;
    color rayleigh = color(0.0435, 0.0993, 0.2247), aerosol = color(1.65, 2.17, 2.82);
    color depth = mass * (rayleigh + beta * aerosol);
    return color(exp(-comp(depth, 0)), exp(-comp(depth, 1)), exp(-comp(depth, 2))) * 1.35;
}

// A distribution of Perez and others: its value towards a height (cosine from the zenith), at an angle from the sun.
float perez(float a, b, c, d, e, high, gamma) {
    float cosine = cos(gamma);
    return (1 + a * exp(b / max(0.02, high))) * (1 + c * exp(d * gamma) + e * cosine * cosine);
}

// How bright the sky is in a direction, z up, without the sun itself.
color sky_color(vector way, sun; float turbidity) {
    float T = turbidity;
    float high = max(0.02, zcomp(normalize(way)));
    float gamma = acos(clamp(normalize(way) . sun, -1, 1));
    // Below the horizon the model has no sun: dusk is the sky of a sun that sets.
    float up = clamp(zcomp(sun), 0.03, 1);
    float t = acos(up), t2 = t * t, t3 = t2 * t;
    float chi = (4 / 9 - T / 120) * (PI - 2 * t);
    float Yz = max(0.2, (4.0453 * T - 4.9710) * tan(chi) - 0.2155 * T + 2.4192);
    float xz = T * T * (0.00166 * t3 - 0.00375 * t2 + 0.00209 * t) + T * (-0.02903 * t3 + 0.06377 * t2 - 0.03202 * t + 0.00394)
               + 0.11693 * t3 - 0.21196 * t2 + 0.06052 * t + 0.25886;
    float yz = T * T * (0.00275 * t3 - 0.00610 * t2 + 0.00317 * t) + T * (-0.04214 * t3 + 0.08970 * t2 - 0.04153 * t + 0.00516)
               + 0.15346 * t3 - 0.26756 * t2 + 0.06670 * t + 0.26688;
    float Ya = 0.1787 * T - 1.4630, Yb = -0.3554 * T + 0.4275, Yc = -0.0227 * T + 5.3251, Yd = 0.1206 * T - 2.5771, Ye = -0.0670 * T + 0.3703;
    float xa = -0.0193 * T - 0.2592, xb = -0.0665 * T + 0.0008, xc = -0.0004 * T + 0.2125, xd = -0.0641 * T - 0.8989, xe = -0.0033 * T + 0.0452;
    float ya = -0.0167 * T - 0.2608, yb = -0.0950 * T + 0.0092, yc = -0.0079 * T + 0.2102, yd = -0.0441 * T - 1.6537, ye = -0.0109 * T + 0.0529;
    float Y = Yz * perez(Ya, Yb, Yc, Yd, Ye, high, gamma) / perez(Ya, Yb, Yc, Yd, Ye, 1, t);
    float x = xz * perez(xa, xb, xc, xd, xe, high, gamma) / perez(xa, xb, xc, xd, xe, 1, t);
    float y = yz * perez(ya, yb, yc, yd, ye, high, gamma) / perez(ya, yb, yc, yd, ye, 1, t);
    // A surface that sends back all of a light of 1 has 31 800 cd/m².
    float luminance = Y / 31.8;
    float X = luminance * x / y, Z = luminance * (1 - x - y) / y;
    color rgb = color(3.2406 * X - 1.5372 * luminance - 0.4986 * Z, -0.9689 * X + 1.8758 * luminance + 0.0415 * Z,
                      0.0557 * X - 0.2040 * luminance + 1.0570 * Z);
    // The model's horizon is too purple: there it has the luminance alone, nearly white and soon blue, in colours that dusk makes warm.
    float low = 1 - smoothstep(0.1, 0.5, high);
    color noon = mix(color(0.86, 1.0, 1.2), color(0.5, 1.0, 1.75), smoothstep(0.01, 0.25, high));
    color pale = mix(color(1.25, 0.95, 0.65), noon, smoothstep(0.05, 0.35, up));
    return mix(max(rgb, color(0, 0, 0)), luminance * pale, low);
}

// What of the model's sky lights surfaces: it is brighter than measured skies. So a clear sky gives a sixth to a third of the light, by the
// height of the sun, and shadows are as deep as photographs have them.
float sky_share() {
    return 0.5;
}

// What of it is seen behind everything.
float seen_share() {
    return 0.78;
}

// The mean of the sky near the horizon.
color horizon_color(vector sun; float turbidity) {
    return 0.25 * (sky_color(vector(0.94, 0, 0.34), sun, turbidity) + sky_color(vector(-0.94, 0, 0.34), sun, turbidity)
                   + sky_color(vector(0, 0.94, 0.34), sun, turbidity) + sky_color(vector(0, -0.94, 0.34), sun, turbidity));
}

// The sky that is seen at the horizon, under the sun (side 1) or opposite to it (-1).
color haze_color(vector sun; float turbidity, side) {
    return seen_share() * sky_color(vector(side * xcomp(sun) + 0.0001, side * ycomp(sun), 0.02), sun, turbidity);
}

#endif
