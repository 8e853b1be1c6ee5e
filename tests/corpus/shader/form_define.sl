#define N 3
#define ADD(a, b) ((a) + (b))
surface t() { Ci = ADD(N, s); }
