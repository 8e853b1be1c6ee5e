surface t() {
    Ci = comp(matrix (1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1), 3, 1);
}
