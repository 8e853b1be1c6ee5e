/* a
 shader */ surface t() { // here
 Ci = /* one */ 1; }
