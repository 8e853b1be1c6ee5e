// APGD: whether a trial is taken, the scalars of the next, and whether there is one.
// in    of_contacts [n_groups]  |z − y|²/η and (N y + r)·(z − x), J
// in    of_bodies   [n_groups]  dᵀNd with d = z − y, J
// inout scalars     [1]
// inout work        [5]         workgroups of an iteration over contacts and over bodies, and of a check
// in    count       [1]         n_contacts
// in    params      [1]         n_bodies
// Twin: cpu/solve/apgd.rs
#import scalars
#import both_totals

@group(0) @binding(0) var<storage, read> of_contacts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> of_bodies: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

const MAX_STEP: f32 = 1e6;
// Trials that a step length is kept after one that was too long, also in short solves, and the most trials of these.
const KEEP: u32 = 10u;
const KEEP_IN_SHORT: u32 = 40u;
const SHORT: u32 = 100u;

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
    // The extrapolation of an iteration follows the one in which the solve ends.
    if !is_active {
        work[1] = vec4(0u, 0u, 1u, 0u);
        work[2] = work[1];
        return;
    }
    let moved = contacts.x;
    let curvature = bodies.x;
    var s = scalars[0];
    s.trials++;
    let is_last = s.trials >= s.limit;
    let least = 1.0 / (3.0 * f32(blocks_of(count[0])));
    // Restart where the step is uphill.
    let is_uphill = contacts.y > 0.0;
    let next_theta = 0.5 * (s.theta * sqrt(s.theta * s.theta + 4.0) - s.theta * s.theta);
    let next_beta = select(s.theta * (1.0 - s.theta) / (s.theta * s.theta + next_theta), 0.0, is_uphill);
    // Short enough if ½ dᵀNd ≤ |d|²/(2 t) in the metric of η, to the rounding of the sums.
    let is_known = curvature > s.rounding;
    if !is_known || curvature * s.step <= moved * 1.00001 || s.step <= least || is_last {
        s.accepted = 1u;
        s.half = 1u - s.half;
        s.beta = next_beta;
        s.theta = select(next_theta, 1.0, is_uphill);
        s.kept++;
        if is_known && s.kept > select(KEEP, KEEP_IN_SHORT, s.limit <= SHORT) {
            s.step = min(1.1 * s.step, MAX_STEP);
        }
    } else {
        s.accepted = 0u;
        s.kept = 0u;
        s.step = max(min(0.95 * moved / curvature, 0.95 * s.step), least);
    }
    if is_last {
        s.goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
    }
    scalars[0] = s;
}
