// The row of a contact whose arms lie along its normal, as between spheres.

// What an iteration needs of a contact: unit normal out of A, offset Φ/h of an open gap, lengths of the arms on A and B along the normal,
// the bodies, the coefficient of friction, the step η = 3 / trace(N_ii), and the adhesion, N s.
struct Row {
    normal: vec3<f32>,
    offset: f32,
    reach: vec2<f32>,
    bodies: vec2<u32>,
    friction: f32,
    eta: f32,
    adhesion: f32,
    pad: u32,
}

// What the angular velocities of the bodies add to the relative velocity.
fn rolling_of(row: Row, wa: vec3<f32>, wb: vec3<f32>) -> vec3<f32> {
    return cross(row.normal, wa * row.reach.x + wb * row.reach.y);
}

// Torque of an impulse on a body.
fn torque_of(row: Row, z: vec3<f32>, is_b: bool) -> vec3<f32> {
    return cross(z, row.normal) * select(row.reach.x, row.reach.y, is_b);
}
