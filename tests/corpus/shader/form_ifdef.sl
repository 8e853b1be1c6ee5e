#ifdef NOTHING
broken here
#else
surface t() { Ci = 1; }
#endif
