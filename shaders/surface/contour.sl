// Contour lines of the height in world space over the primitive's colour, every fifth one stronger.
surface contour(float Ka = 1; float Kd = 0.9; float interval = 0.1; float width = 1.2; color line = color(0.25, 0.15, 0.05); float tinted = 1;) {
    normal Nf = faceforward(normalize(N), I);
    float h = zcomp(transform("world", P)) / interval;
    float off = abs(mod(h + 0.5, 1) - 0.5) / max(filterwidth(h), 1e-6);
    float strong = abs(mod(floor(h + 0.5), 5)) < 0.5 ? 2 : 1;
    float on = 1 - smoothstep(0.5 * width * strong, 0.5 * width * strong + 1, off);
    color ground = Cs;
    if (tinted != 0)
        ground *= spline(clamp(h / 20 + 0.5, 0, 1), color(0.5, 0.6, 0.4), color(0.6, 0.68, 0.45), color(0.8, 0.75, 0.55), color(0.75, 0.62, 0.45), color(0.9, 0.88, 0.85));
    Oi = Os;
    Ci = Os * mix(ground * (Ka * ambient() + Kd * diffuse(Nf)), line, 0.85 * on);
}
