// Scaling of the starting point: the factor of the least objective along it, and the most iterations.
// in    of_contacts [n_groups]  J: γ·(Nγ + r), |γ|²/η
// in    of_bodies   [n_groups]  J: γᵀNγ, energy of the bodies
// inout scalars     [1]
// in    count       [1]         n_contacts
// in    params      [3]         n_bodies; the most iterations, 0 for the default; whether the tips of cones are below zero
// Twin: cpu/solve/scale.rs
#import scalars
#import partial

@group(0) @binding(0) var<storage, read> of_contacts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> of_bodies: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

// Change of the factor that is near 1.
const NEAR: f32 = 0.1;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var contacts = vec4(0.0);
    for (var i = thread; i < groups_of(count[0]); i += 256u) {
        contacts += of_contacts[i];
    }
    contacts = group_total(thread, contacts);
    var bodies = vec4(0.0);
    for (var i = thread; i < groups_of(params[0]); i += 256u) {
        bodies += of_bodies[i];
    }
    bodies = group_total(thread, bodies);
    if thread != 0u {
        return;
    }
    let n = blocks_of(count[0]);
    let limit = max_iterations(params[1], n);
    let found = 1.0 - contacts.x / bodies.x;
    var factor = select(1.0, clamp(found, 0.0, select(3e38, 1.0, params[2] == 1u)), bodies.x > 0.0 && is_finite(found));
    if n > limit && abs(factor - 1.0) <= NEAR {
        factor = 1.0;
    }
    scalars[0].factor = factor;
    scalars[0].limit = limit;
    // The square of what single precision loses of velocities that are sums of impulses which cancel.
    scalars[0].rounding = 4e-14 * (contacts.y + bodies.y);
    // Not zero if there is an impulse to start from.
    scalars[0].last_step2 = contacts.y;
}
