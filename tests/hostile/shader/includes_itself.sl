#include "includes_itself.sl"
surface includes_itself() { Ci = 1; }