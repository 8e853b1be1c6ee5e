// A lamp that shines all around, with the name of a shadow map; the shadow itself is traced.
light shadowpoint(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0);
                  string shadowname = ""; float samples = 16; float blur = 0;) {
    illuminate(from) {
        Cl = intensity * lightcolor / (L . L);
        if (shadowname != "")
            Cl *= 1 - shadow(shadowname, Ps, "samples", samples, "blur", blur);
    }
}
