// Fades with depth between two distances from the camera.
volume depthcue(float mindistance = 0, maxdistance = 1; color background = 0;) {
    float d = clamp((zcomp(transform("camera", P)) - mindistance) / (maxdistance - mindistance), 0, 1);
    Ci = mix(Ci, background, d);
    Oi = mix(Oi, color(1, 1, 1), d);
}
