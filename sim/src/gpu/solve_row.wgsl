// The rows that the solver's kernels share.
#import row

// Velocity and inverse mass of a body, angular velocity and inverse moment of inertia, world.
struct Body {
    v: vec3<f32>,
    inv_mass: f32,
    w: vec3<f32>,
    inv_inertia: f32,
}

// Whether joints act on a body, whose energy they then sum.
fn is_joined(body: Body) -> bool {
    return body.inv_inertia < 0.0;
}
