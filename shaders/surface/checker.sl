// A floor of squares with sides of `size` in world units, and a bar of ten squares along x that tells the scale.
surface checker(float Ka = 1; float Kd = 0.9; float size = 1; color light = color(0.82, 0.82, 0.8); color dark = color(0.62, 0.63, 0.65);
                float bar = 1; color barcolor = color(0.85, 0.2, 0.1); point origin = point "world" (0, 0, 0);) {
    normal Nf = faceforward(normalize(N), I);
    vector q = vtransform("shader", P - origin);
    float x = xcomp(q) / size, y = ycomp(q) / size;
    // Squares fade to their mean where they are finer than the grid.
    float wide = max(filterwidth(x), filterwidth(y));
    float odd = mod(floor(x) + floor(y), 2);
    color c = mix(mix(light, dark, odd), 0.5 * (light + dark), smoothstep(0.4, 1, wide));
    if (bar != 0 && x >= 0 && x <= 10 && y >= -0.25 && y <= 0)
        c = mod(floor(x), 2) == 0 ? barcolor : color(1, 1, 1);
    Oi = Os;
    Ci = Os * Cs * c * (Ka * ambient() + Kd * diffuse(Nf));
}
