#ifdef X // FAULT
surface s() { Ci = 1; }
