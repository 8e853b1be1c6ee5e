// A colour behind everything.
imager background(color bgcolor = 0; color background = 0;) {
    Ci += (1 - alpha) * (bgcolor + background);
    Oi = 1;
    alpha = 1;
}
