#define A 1
#undef A
#ifndef A
surface t() { Ci = 1; }
#endif
