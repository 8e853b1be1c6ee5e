// The sun: parallel light, with shadows unless shadowname is "". With an angle, degrees, it is a disc in the sky, and its shadows
// are soft: of so many samples.
light distantlight(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0); point to = point "shader" (0, 0, 1);
                   string shadowname = "raytrace"; float angle = 0; float samples = 16;) {
    vector way = normalize(to - from);
    solar(way, 0) {
        Cl = intensity * lightcolor;
        if (shadowname != "") {
            if (angle > 0) {
                // Places on the disc along a spiral that is turned from point to point.
                vector across = normalize(abs(xcomp(way)) < 0.7 ? vector (1, 0, 0) ^ way : vector (0, 1, 0) ^ way);
                vector up = way ^ across;
                float turn = 2 * PI * float cellnoise(8192 * Ps);
                color lit = 0;
                uniform float i;
                for (i = 0; i < samples; i += 1) {
                    float r = tan(radians(angle / 2)) * sqrt((i + 0.5) / samples);
                    float a = turn + i * 2.399963;
                    lit += transmission(Ps, Ps - 100000 * (way + r * (cos(a) * across + sin(a) * up)));
                }
                Cl *= lit / samples;
            } else {
                Cl *= transmission(Ps, Ps - 100000 * way);
            }
        }
    }
}
