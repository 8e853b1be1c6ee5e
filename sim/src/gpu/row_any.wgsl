// The row of a contact with arms of any direction.

// What an iteration needs of a contact: unit normal out of A, offset Φ/h of an open gap, arms on A and B, m, the coefficient of friction,
// the step η = 3 / trace(N_ii), the bodies, the velocity along the normal that an impulse along it gives, 1/kg, and
// the adhesion, N s.
struct Row {
    normal: vec3<f32>,
    offset: f32,
    arm_a: vec3<f32>,
    friction: f32,
    arm_b: vec3<f32>,
    eta: f32,
    bodies: vec2<u32>,
    response: f32,
    adhesion: f32,
}

// What the angular velocities of the bodies add to the relative velocity.
fn rolling_of(row: Row, wa: vec3<f32>, wb: vec3<f32>) -> vec3<f32> {
    return cross(wb, row.arm_b) - cross(wa, row.arm_a);
}

// Torque of an impulse on a body; it is minus the impulse on A.
fn torque_of(row: Row, z: vec3<f32>, is_b: bool) -> vec3<f32> {
    if is_b {
        return cross(row.arm_b, z);
    }
    return cross(z, row.arm_a);
}
