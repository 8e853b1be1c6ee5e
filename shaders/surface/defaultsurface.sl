// What is drawn where no surface shader is named: lit from the eye, so that shape shows without lights.
surface defaultsurface(float Kd = 0.8; float Ka = 0.2;) {
    float facing = abs(normalize(N) . normalize(I));
    Oi = Os;
    Ci = Os * Cs * (Ka + Kd * facing);
}
