// Residual terms of the solution squared, summed over a workgroup.
// in   row      [n_contacts]
// in   motion   [n_bodies]    m/s, rad/s
// in   gamma    [n_contacts]  N s, world
// out  parts    [n_groups]    m²/s²
// in   count    [1]           n_contacts
// in    roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row [n_contacts]
// Twin: cpu/solve/residual.rs
#import sphere
#import project
#import residual_term
#import partial
#import roll

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> gamma: array<vec4<f32>>;
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
        let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let term = residual_term(gamma[k].xyz, gradient, row);
        own.x = dot(term, term);
        if ROLLS {
            let turning = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
            let of_roll = roll_term(roll[k].xyz, turning, row, gamma[k].xyz, roll_row[k]);
            own.x += dot(of_roll, of_roll) * roll_row[k].w;
        }
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
