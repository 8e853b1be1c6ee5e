// Impulse, N s, and angular impulse, N m s.
struct Impulse {
    linear: vec3<f32>,
    angular: vec3<f32>,
}
