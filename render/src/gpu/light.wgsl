// The light that gets from one point to another, where nothing lets a part of it through.

fn light_along(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(1.0), vec3<f32>(), is_blocked(start, end));
}
