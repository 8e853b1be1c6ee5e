#define SUM(a, b) \
    ((a) + \
     (b))
surface t() { Ci = SUM(1, 2); }
