// Plastic with a image on it.
surface paintedplastic(float Ka = 1; float Kd = 0.5; float Ks = 0.5; float roughness = 0.1; color specularcolor = 1;
                       string texturename = "";) {
    normal Nf = faceforward(normalize(N), I);
    vector V = -normalize(I);
    color Ct = texturename == "" ? color(1, 1, 1) : color texture(texturename);
    Oi = Os;
    Ci = Os * (Cs * Ct * (Ka * ambient() + Kd * diffuse(Nf)) + specularcolor * Ks * specular(Nf, V, roughness));
}
