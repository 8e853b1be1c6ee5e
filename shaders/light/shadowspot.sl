// A lamp with a cone, with the name of a shadow map; the shadow itself is traced.
light shadowspot(float intensity = 1; color lightcolor = 1; point from = point "shader" (0, 0, 0);
                 point to = point "shader" (0, 0, 1); float coneangle = radians(30); float conedeltaangle = radians(5);
                 float beamdistribution = 2; string shadowname = ""; float samples = 16; float blur = 0;) {
    uniform vector axis = normalize(to - from);
    illuminate(from, axis, coneangle) {
        float cosangle = (L . axis) / length(L);
        float atten = pow(cosangle, beamdistribution) / (L . L);
        atten *= smoothstep(cos(coneangle), cos(coneangle - conedeltaangle), cosangle);
        Cl = atten * intensity * lightcolor;
        if (shadowname != "")
            Cl *= 1 - shadow(shadowname, Ps, "samples", samples, "blur", blur);
    }
}
