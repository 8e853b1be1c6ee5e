// Inertia of any bodies, from the columns `mass` and `orientation` of the kernel.
#import turn

// The angular velocity that an angular impulse gives a body.
fn turned_by(body: u32, own: Body, turn: vec3<f32>) -> vec3<f32> {
    let q = orientation[body];
    return turned(q, turned_back(q, turn) * mass[body].yzw);
}

// Twice the energy of an angular velocity.
fn turning_energy(body: u32, own: Body, w: vec3<f32>) -> f32 {
    let local = turned_back(orientation[body], w);
    return dot(local, local / mass[body].yzw);
}
