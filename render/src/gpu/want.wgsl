// Points whose colours are needed: a bit each.

fn want(point: u32) {
    let bit = 1u << (point & 31u);
    if (atomicLoad(&wanted[point >> 5u]) & bit) == 0u {
        atomicOr(&wanted[point >> 5u], bit);
    }
}

// The corners of a triangle that a sample sees, or the first if it is of one colour.
fn want_corners(id: u32, m: vec4<u32>) {
    want(m.x);
    if (m.z & 1u) != 0u {
        want(m.x + m.y + 1u);
        want(m.x + select(1u, m.y, (id & 1u) != 0u));
    }
}
