half(float x) { return x / 2; }
surface untyped() {
    twice(float x) { return x * 2; }
    Oi = 1;
    Ci = half(twice(half(3)));
}
