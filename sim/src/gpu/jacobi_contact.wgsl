// Projected Jacobi, first half of an iteration: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, from the velocities that γ gives the bodies.
// in    row     [n_contacts]
// in    motion  [n_bodies]    m/s, rad/s
// inout gamma   [n_contacts]  N s, world; the fourth number is not used
// in    count   [1]           n_contacts
// in    params  [2]           as bits: ω, λ
// Twin: cpu/solve/jacobi.rs
#import sphere
#import project

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let row = rows[k];
    let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
    let x = gamma[k].xyz;
    let z = project(x - gradient * (bitcast<f32>(params[0]) * row.eta), row.normal, row.friction);
    let lambda = bitcast<f32>(params[1]);
    gamma[k] = vec4(z * lambda + x * (1.0 - lambda), 0.0);
}
