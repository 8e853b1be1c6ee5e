// The light that gets from one point to another.

fn scene_transmission(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    return light_along(start, end);
}
