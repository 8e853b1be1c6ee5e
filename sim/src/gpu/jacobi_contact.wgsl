// Projected Jacobi, first half of an iteration: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, from the velocities that γ gives the bodies.
// in    row      [n_contacts]
// in    motion   [n_bodies]    m/s, rad/s
// inout gamma    [n_contacts]  N s, world; the fourth number is not used
// in    scalars  [1]
// out   parts    [n_groups]    residual terms of γ squared, |γ⁺ − γ|²/η, |γ|²/η, summed over a workgroup
// in    count    [1]           n_contacts
// in    params   [1]           as bits: λ
// Twin: cpu/solve/jacobi.rs
#import sphere
#import project
#import residual_term
#import scalars
#import partial

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(4) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let x = gamma[k].xyz;
        let z = project(x - gradient * (scalars[0].omega * row.eta), row.normal, row.friction);
        let lambda = bitcast<f32>(params[0]);
        let next = z * lambda + x * (1.0 - lambda);
        gamma[k] = vec4(next, 0.0);
        let term = residual_term(x, gradient, row.normal, row.friction, row.eta);
        own = vec4(dot(term, term), dot(next - x, next - x) / row.eta, dot(x, x) / row.eta, 0.0);
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
