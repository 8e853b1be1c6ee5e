// A pane of coloured glass, thin and even: it holds back what Os says and shows a sheen of its own colour.
surface pane(float Ka = 0.25; float Kd = 0.35; float Ks = 0.4; float roughness = 0.08;) {
    normal Nf = faceforward(normalize(N), I);
    Oi = Os;
    Ci = Os * Cs * (Ka * ambient() + Kd * diffuse(Nf)) + Ks * specular(Nf, -normalize(I), roughness);
}
