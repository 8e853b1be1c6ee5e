surface t() { /* never ends
}
