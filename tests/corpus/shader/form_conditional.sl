#if defined(FOO) || 1
#define X 1
#elif 1
#define X 2
#else
#define X 3
#endif
surface t() { Ci = X; }
