// A point of a contact: unit normal from the first shape to the second, the points on both, m, the gap, m, and the feature id.
struct Point {
    normal: vec3<f32>,
    on_first: vec3<f32>,
    on_second: vec3<f32>,
    gap: f32,
    feature: u32,
}
