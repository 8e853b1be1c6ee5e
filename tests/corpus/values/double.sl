imager double() { Ci = 2 * Ci; }
