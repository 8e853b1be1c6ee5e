// Scaling of the starting point: γ·(Nγ + r) and |γ|²/η, summed over a workgroup.
// in   row      [n_contacts]
// in   gamma    [n_contacts]  N s, world
// in   motion   [n_bodies]    m/s, rad/s: velocities with γ
// out  parts    [n_groups]    J
// in   count    [1]           n_contacts
// in    roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row [n_contacts]
// Twin: cpu/solve/scale.rs
#import sphere
#import project
#import partial
#import roll

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> motion: array<Body>;
@group(0) @binding(3) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> roll: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> roll_row: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let z = gamma[k].xyz;
        let slope = dot(z, gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]));
        own = vec4(slope, dot(z, z) / row.eta, 0.0, 0.0);
        if ROLLS {
            let own_roll = roll[k].xyz;
            let turning = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
            own += vec4(dot(own_roll, turning), dot(own_roll, own_roll) / roll_row[k].z, 0.0, 0.0);
        }
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
