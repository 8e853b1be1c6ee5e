// Rubber: nearly black, with a broad dull sheen.
surface rubber(float Ka = 1; float Kd = 0.9; float Ks = 0.12; float dust = 0.15; color tint = color(0.045, 0.045, 0.048);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    float up = max(0, zcomp(ntransform("world", Nf)));
    color c = mix(tint, color(0.4, 0.35, 0.28), dust * up * noise(transform("object", P) * 12));
    Oi = Os;
    Ci = Os * Cs * (c * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * specular(Nf, V, 0.35));
}
