// The rows that the solver's kernels share.

// Velocity and inverse mass of a body, angular velocity and inverse moment of inertia, world.
struct Body {
    v: vec3<f32>,
    inv_mass: f32,
    w: vec3<f32>,
    inv_inertia: f32,
}

// What an iteration needs of a contact: unit normal out of A, offset Φ/h of an open gap, lengths of the arms on A and B along the normal,
// the bodies, the coefficient of friction and the step η = 3 / trace(N_ii).
struct Row {
    normal: vec3<f32>,
    offset: f32,
    reach: vec2<f32>,
    bodies: vec2<u32>,
    friction: f32,
    eta: f32,
}
