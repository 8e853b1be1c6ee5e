// Broken stone: bumps of three sizes, in the stone's own space. Km: greatest height, in the unit of that space; size: of the largest bump.
displacement rock(float Km = 0.005; float size = 0.05;) {
    point Q = transform("object", P) / size;
    float bumps = (noise(Q) - 0.5) * 1.2 + (noise(Q * 2.2) - 0.5) * 0.5 + (noise(Q * 5.1) - 0.5) * 0.2;
    // No bump is higher than Km, so that Km is also the displacement bound.
    P += Km * clamp(bumps, -1, 1) * normalize(N);
    N = calculatenormal(P);
}
