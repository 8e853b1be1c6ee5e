// What a push along the normal of a contact does where arms lie along it: they have no part in it.
// Twin: cpu/solve/overlaps.rs

// Relative speed along the normal, and the speed that an impulse along it gives, 1/kg.
fn pushed_by(k: u32, normal: vec3<f32>, a: Body, b: Body) -> vec2<f32> {
    return vec2(dot(b.v - a.v, normal), a.inv_mass + b.inv_mass);
}
