#include "nowhere.h" // FAULT
surface s() { Ci = 1; }
