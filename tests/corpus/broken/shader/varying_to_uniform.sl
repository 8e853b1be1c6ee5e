surface t() {
    uniform float x = s; // FAULT
}
