// Stones with darker flecks, in the object's own colour: a shader that is yours to change.
surface pebble(float flecks = 30;) {
    normal Nf = faceforward(normalize(N), I);
    point Q = flecks * transform("object", P);
    float dark = smoothstep(0.45, 0.75, noise(Q));
    Oi = Os;
    Ci = Os * Cs * (1 - 0.45 * dark) * (ambient() + diffuse(Nf));
}
