// How far along a ray from the surface that is shaded anything is met; negative if nothing is.

fn scene_hit(start: vec3<f32>, direction: vec3<f32>) -> f32 {
    return nearest(start, direction);
}
