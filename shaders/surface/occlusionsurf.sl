// How open to the sky each point is: white in the open, black in corners. For passes of ambient occlusion.
surface occlusionsurf(float samples = 64; float Kd = 1;) {
    normal Nf = faceforward(normalize(N), I);
    Oi = Os;
    Ci = Os * Kd * (1 - occlusion(P, Nf, samples));
}
