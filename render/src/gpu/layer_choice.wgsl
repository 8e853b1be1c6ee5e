// The triangle of a micropolygon that has a sample of layers: on an edge that two of them share, one of these.
// Twin: cpu/still.rs

// Whether it is met, and which triangle; what is known of a layer there beside its id.
struct Choice {
    is_met: bool,
    is_second: bool,
    flags: u32,
}

fn choose(m: vec4<u32>, q: Quad, d: vec2<f32>, first: Meeting, second: Meeting) -> Choice {
    let v = around(m, -d, q.b.xy - d, q.c.xy - d, q.d.xy - d);
    let inside = insides(v);
    let is_second = inside.y && (!inside.x || second.z < first.z);
    return Choice(inside.x || inside.y, is_second, edge_flags(v, is_second));
}
