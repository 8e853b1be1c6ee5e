surface t() {
    Ci = float environment("e.env"[0], N, "blur", 0.1);
}
