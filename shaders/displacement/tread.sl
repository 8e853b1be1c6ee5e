// The tread of a tyre: bars across, set off from each other on both halves. `s` runs around, `t` across.
displacement tread(float Km = 0.02; float bars = 40; float depth = 1;) {
    float half = step(0.5, t);
    float around = mod(s * bars + 0.5 * half, 1);
    float slant = mod(around + abs(t - 0.5) * 1.5, 1);
    float bar = smoothstep(0.1, 0.25, slant) * (1 - smoothstep(0.55, 0.7, slant));
    float shoulder = smoothstep(0.02, 0.1, t) * (1 - smoothstep(0.9, 0.98, t));
    P += Km * depth * bar * shoulder * normalize(N);
    N = calculatenormal(P);
}
