// Light from all around, as a image of the whole sky has it (longitude and latitude, z up, or six faces): an area light whose
// surface is a great sphere turned inside out about the scene, ReverseOrientation Sphere 1000 -1000 1000 360.
light envlight(float intensity = 1; color lightcolor = 1; string envname = ""; float area = 1; string shadowname = "raytrace";) {
    illuminate(P, N, PI / 2) {
        color sky = envname != "" ? color environment(envname, vtransform("world", -L)) : color 1;
        Cl = intensity * lightcolor * sky * area * (L . normalize(N)) / (PI * (L . L) * length(L));
        if (shadowname != "") {
            Cl *= transmission(Ps, P);
        }
    }
}
