displacement seen() { P += vector(0, 0, 0.1 * zcomp(E)); }
