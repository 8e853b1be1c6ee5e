// Spectral projected gradients: how far to go along the step, the next step length, and whether there is another iteration.
// in    of_contacts [n_groups]  |z − x|²/η and (N x + r)·(z − x), J
// in    of_bodies   [n_groups]  dᵀNd with d = z − x, J
// inout scalars     [1]         ω is the step length α, β one less than the share of the step that is taken
// inout work        [5]         workgroups of an iteration over contacts and over bodies, and of a check
// in    count       [1]         n_contacts
// in    params      [1]         n_bodies
// Twin: cpu/solve/barzilai_borwein.rs
#import scalars
#import both_totals

@group(0) @binding(0) var<storage, read> of_contacts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> of_bodies: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let is_active = scalars[0].goes_on == 1u;
    let n_of_contacts = select(0u, groups_of(count[0]), is_active);
    let contacts = contacts_total(thread, n_of_contacts);
    let n_of_bodies = select(0u, groups_of(params[0]), is_active);
    let bodies = bodies_total(thread, n_of_bodies);
    if thread != 0u {
        return;
    }
    // The last step is taken in the iteration in which the solve ends.
    if !is_active {
        work[1] = vec4(0u, 0u, 1u, 0u);
        work[2] = work[1];
        return;
    }
    let length2 = contacts.x;
    let slope = contacts.y;
    let curvature = bodies.x;
    var s = scalars[0];
    s.trials++;
    s.beta = 0.0;
    // A curvature that is lost in the rounding of the velocities says nothing of the next step.
    if curvature > s.rounding {
        if slope < 0.0 {
            s.beta = min(-slope / curvature, 1.0) - 1.0;
        }
        s.omega = clamp(length2 / curvature, 1e-4, 1e4);
    } else if curvature <= 0.0 {
        s.omega = 1e4;
    }
    // Without a step every block is at its projection: the iterate is the solution.
    if !(length2 > 0.0) || s.trials >= s.limit {
        s.goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
    }
    scalars[0] = s;
}
