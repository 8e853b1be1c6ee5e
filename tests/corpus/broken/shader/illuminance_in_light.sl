light t() {
    illuminance(Ps) { Cl = 1; } // FAULT
}
