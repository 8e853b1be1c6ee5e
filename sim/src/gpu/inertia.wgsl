// Inertia of bodies whose principal moments are equal.

// The angular velocity that an angular impulse gives a body.
fn turned_by(body: u32, own: Body, turn: vec3<f32>) -> vec3<f32> {
    return turn * own.inv_inertia;
}

// Twice the energy of an angular velocity.
fn turning_energy(body: u32, own: Body, w: vec3<f32>) -> f32 {
    return dot(w, w) / own.inv_inertia;
}
