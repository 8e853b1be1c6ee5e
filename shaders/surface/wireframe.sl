// Lines along the primitive's parameters over its colour.
surface wireframe(float Ka = 1; float Kd = 0.9; float ulines = 10, vlines = 10; float width = 1.5; color line = color(0.05, 0.05, 0.08);) {
    normal Nf = faceforward(normalize(N), I);
    float near_u = abs(mod(s * ulines + 0.5, 1) - 0.5) / max(filterwidth(s * ulines), 1e-6);
    float near_v = abs(mod(t * vlines + 0.5, 1) - 0.5) / max(filterwidth(t * vlines), 1e-6);
    float on = 1 - smoothstep(0.5 * width, 0.5 * width + 1, min(near_u, near_v));
    Oi = Os;
    Ci = Os * mix(Cs * (Ka * ambient() + Kd * diffuse(Nf)), line, on);
}
