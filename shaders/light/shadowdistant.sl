// Light from far away, with the name of a shadow map; the shadow itself is traced.
light shadowdistant(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0);
                    point to = point "shader" (0, 0, 1); string shadowname = ""; float samples = 16; float blur = 0;) {
    solar(to - from, 0) {
        Cl = intensity * lightcolor;
        if (shadowname != "")
            Cl *= 1 - shadow(shadowname, Ps, "samples", samples, "blur", blur);
    }
}
