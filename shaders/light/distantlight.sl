// The sun: parallel light, with shadows unless shadowname is "".
light distantlight(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0); point to = point "shader" (0, 0, 1);
                   string shadowname = "raytrace";) {
    vector way = normalize(to - from);
    solar(way, 0) {
        Cl = intensity * lightcolor;
        if (shadowname != "") {
            Cl *= transmission(Ps, Ps - 100000 * way);
        }
    }
}
