// Of the triangles of a micropolygon that a sample meets, the nearer one.

// Whether it is met, and which triangle; what is known of a layer there beside its id.
struct Choice {
    is_met: bool,
    is_second: bool,
    flags: u32,
}

fn choose(m: vec4<u32>, q: Quad, d: vec2<f32>, first: Meeting, second: Meeting) -> Choice {
    return Choice(true, second.inside && (!first.inside || second.z < first.z), 0u);
}
