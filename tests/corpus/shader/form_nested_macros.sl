#define A B
#define B C(2)
#define C(x) (x * x)
surface t() { Ci = A; }
