// What a push along the normal of a contact does, from the column `rows` of the kernel.
// Twin: cpu/solve/overlaps.rs

// Relative speed along the normal, and the speed that an impulse along it gives, 1/kg.
fn pushed_by(k: u32, normal: vec3<f32>, a: Body, b: Body) -> vec2<f32> {
    let row = rows[k];
    return vec2(dot(b.v - a.v + rolling_of(row, a.w, b.w), normal), row.response);
}
