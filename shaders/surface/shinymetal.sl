// Polished metal that mirrors an environment map.
surface shinymetal(float Ka = 1; float Ks = 1; float Kr = 1; float roughness = 0.1; string texturename = "";) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    color env = 0;
    if (texturename != "")
        env = Kr * environment(texturename, vtransform("world", reflect(-V, Nf)));
    Oi = Os;
    Ci = Os * Cs * (Ka * ambient() + Ks * specular(Nf, V, roughness) + env);
}
