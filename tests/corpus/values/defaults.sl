surface defaults(varying float across = u; varying color own = Cs; uniform float later = time + 2;) { Oi = 1; Ci = color(across, comp(own, 1), later); }
