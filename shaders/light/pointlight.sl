// A lamp: light from a point that falls off with the square of the distance, with shadows unless shadowname is "".
light pointlight(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0); string shadowname = "raytrace";) {
    illuminate(from) {
        Cl = intensity * lightcolor / (L . L);
        if (shadowname != "") {
            Cl *= transmission(Ps, from);
        }
    }
}
