// Thin glass: clear in the middle, mirroring at the rim (Fresnel); rays do not bend.
surface glass(float Ka = 0.2; float Ks = 0.8; float Kr = 0.6; float roughness = 0.05; float eta = 1.5; color tint = color(0.9, 0.97, 0.95);
              string texturename = ""; color sky = color(0.7, 0.8, 0.9);) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    float kr, kt;
    fresnel(normalize(I), Nf, 1 / eta, kr, kt);
    vector R = reflect(-V, Nf);
    color mirrored = texturename != "" ? color environment(texturename, vtransform("world", R)) : sky * (0.4 + 0.6 * max(0, zcomp(vtransform("world", R))));
    float opaque = clamp(kr + 0.06, 0, 1);
    Oi = mix(1 - tint, color(1, 1, 1), opaque) * Os;
    Ci = Ka * ambient() * (1 - tint) + Kr * kr * mirrored + Ks * specular(Nf, V, roughness);
}
