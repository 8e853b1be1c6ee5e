#define F(a, b) a + b
surface s() {
    Ci = F(1); // FAULT
}
