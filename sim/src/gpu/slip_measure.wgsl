// The slip of each contact with the velocities of a solution, its change and its sum over a workgroup.
// in    row      [n_contacts]
// in    motion   [n_bodies]    m/s, rad/s
// in    gamma    [n_contacts]  N s, world
// inout slip     [n_contacts]  m/s: the offset without slip, the slip that is fed; the next one out
// out   parts    [n_groups]    m/s: |change|, slip
// in    count    [1]           n_contacts
// in    params   [1]           as bits: slip over μ below which none is fed (m/s)
// Twin: cpu/solve/slip.rs
#import sphere
#import project
#import creep
#import partial

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> slip: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let v = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let next = slip_of(v, gamma[k].xyz, row.normal, row.friction, bitcast<f32>(params[0]));
        own = vec4(abs(next - slip[k].y), next, 0.0, 0.0);
        slip[k].z = next;
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
