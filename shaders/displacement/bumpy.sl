// Bumps by a image.
displacement bumpy(float Km = 1; string texturename = "";) {
    float amplitude = 0;
    if (texturename != "")
        amplitude = Km * float texture(texturename);
    P += amplitude * normalize(N);
    N = calculatenormal(P);
}
