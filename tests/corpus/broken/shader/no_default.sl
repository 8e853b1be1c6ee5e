surface t(float Kd;) { // FAULT
    Ci = Kd;
}
