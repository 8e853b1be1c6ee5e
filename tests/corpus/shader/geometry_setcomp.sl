surface t() {
    point q = P; setxcomp(q, 1); setycomp(q, 2); setzcomp(q, 3); Ci = length(q);
}
