#include "/dev/zero"
surface includes_device() { Ci = 1; }