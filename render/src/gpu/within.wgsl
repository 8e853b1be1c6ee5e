// Weights of places in triangles.
// Twin: cpu/samples.rs

// Weights of a point of a triangle; of one on the widened edge, those of a point inside nearby.
fn within(w: vec3<f32>) -> vec3<f32> {
    if all(w >= vec3<f32>()) {
        return w;
    }
    let inside = max(w, vec3<f32>());
    return inside / (inside.x + inside.y + inside.z);
}

// The points of the second and the third corner of a micropolygon's triangle.
fn others(m: vec4<u32>, is_second: bool) -> vec2<u32> {
    let across = m.x + m.y + 1u;
    return select(vec2<u32>(m.x + 1u, across), vec2<u32>(across, m.x + m.y), is_second);
}
