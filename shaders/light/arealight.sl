// A lamp that has a surface, the primitives that follow AreaLightSource: each part of it shines as bright from all sides, which is
// what intensity says, and casts shadows of its own. The renderer tells it its area.
light arealight(float intensity = 1; color lightcolor = 1; float area = 1; string shadowname = "raytrace";) {
    illuminate(P, N, PI / 2) {
        Cl = intensity * lightcolor * area * (L . normalize(N)) / (PI * (L . L) * length(L));
        if (shadowname != "") {
            Cl *= transmission(Ps, P);
        }
    }
}
