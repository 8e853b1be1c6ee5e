surface t() {
    Ci = N . I;
}
