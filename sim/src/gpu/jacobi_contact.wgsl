// Projected Jacobi, first half of an iteration: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, from the velocities that γ gives the bodies.
// inout row      [n_contacts]
// in    motion   [n_bodies]    m/s, rad/s
// inout gamma    [n_contacts]  N s, world; the fourth number as in `spin.wgsl`
// in    scalars  [1]
// out   parts    [n_groups]    residual terms of γ squared, |γ⁺ − γ|²/η, |γ|²/η, and what of the terms is rounding, summed over a workgroup
// in    count    [1]           n_contacts
// inout roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row [n_contacts]
// in    slip     [n_contacts]  m/s, where slip is fed: the offset without slip
// out   spin     [n_contacts]  N m s, N s or world: what γ⁺ turns the bodies by
// in    params   [4]           as bits: λ; whether the slip of each iterate is fed, by Coulomb's law itself; the least slip over μ that is
//                              fed (m/s), and slip that is known over the root of the number of blocks (m/s)
// Twin: cpu/solve/jacobi.rs
#import sphere
#import project
#import creep
#import residual_term
#import scalars
#import partial
#import roll
#import leave_spin

@group(0) @binding(0) var<storage, read_write> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(4) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> slip: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> spin: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

// The step of the rolling impulse of a contact with the impulse γ, and what it adds to the sums.
fn roll_step(k: u32, row: Row, gamma_k: vec3<f32>, lambda: f32) -> vec4<f32> {
    let of_roll = roll_row[k];
    let x = roll[k].xyz;
    let gradient = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
    let z = project_roll(x - gradient * (scalars[0].omega * of_roll.z), row, gamma_k, of_roll);
    let next = z * lambda + x * (1.0 - lambda);
    roll[k] = vec4(next, 0.0);
    let term = roll_term(x, gradient, row, gamma_k, of_roll);
    return vec4(dot(term, term) * of_roll.w, dot(next - x, next - x) / of_roll.z, dot(x, x) / of_roll.z, 0.0);
}

// The step of a contact, if there is such a one. Returns what it adds to the sums.
fn step_of(k: u32) -> vec4<f32> {
    if k >= count[0] {
        return vec4(0.0);
    }
    let row = rows[k];
    var gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
    let x = gamma[k].xyz;
    if params[1] == 1u {
        let known = bitcast<f32>(params[3]) * sqrt(f32(blocks_of(count[0])));
        let least_speed = min(bitcast<f32>(params[2]), known);
        let offset = slip[k].x + slip_of(gradient, x, row.normal, row.friction, least_speed);
        gradient += row.normal * (offset - row.offset);
        rows[k].offset = offset;
    }
    let z = project_row(x - gradient * (scalars[0].omega * row.eta), row);
    let lambda = bitcast<f32>(params[0]);
    let next = z * lambda + x * (1.0 - lambda);
    gamma[k] = with_arm(row, next);
    leave_spin(k, row, next);
    let term = residual_term(x, gradient, row);
    let rounding = rounding_of(row, motion[row.bodies.x], motion[row.bodies.y]);
    var own = vec4(dot(term, term), dot(next - x, next - x) / row.eta, dot(x, x) / row.eta, rounding);
    if ROLLS {
        own += roll_step(k, row, x, lambda);
    }
    return own;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let end = select(0u, groups_of(count[0]), scalars[0].goes_on == 1u);
    for (var block = group.x; block < end; block += groups.x) {
        let sum = group_total(thread, step_of(block * 256u + thread));
        if thread == 0u {
            parts[block] = sum;
        }
    }
}
