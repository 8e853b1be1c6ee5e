surface t() {
    ;
}
