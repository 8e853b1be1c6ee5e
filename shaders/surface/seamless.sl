// A matte floor that fades away from its middle into what is behind it. near, far: radii in object space between which it fades.
surface seamless(float Ka = 1; float Kd = 0.9; float near = 1; float far = 4;) {
    point Q = transform("object", P);
    float r = sqrt(xcomp(Q) * xcomp(Q) + ycomp(Q) * ycomp(Q));
    normal Nf = faceforward(normalize(N), I);
    Oi = Os * (1 - smoothstep(near, far, r));
    Ci = Oi * Cs * (Ka * ambient() + Kd * diffuse(Nf));
}
