// Scaling of the starting point: lengths of the residual terms with γ as it is and scaled, summed over a workgroup.
// in   row      [n_contacts]
// in   gamma    [n_contacts]  N s, world
// in   motion   [n_bodies]    m/s, rad/s: velocities with γ
// in   free     [n_bodies]    m/s, rad/s: velocities without contacts
// in   scalars  [1]
// out  parts    [n_groups]    m/s
// in   count    [1]           n_contacts
// in    roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row [n_contacts]
// Twin: cpu/solve/scale.rs
#import sphere
#import project
#import residual_term
#import scalars
#import partial
#import roll

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> motion: array<Body>;
@group(0) @binding(3) var<storage, read> free: array<Body>;
@group(0) @binding(4) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(5) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> roll: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> roll_row: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let z = gamma[k].xyz;
        let factor = scalars[0].factor;
        let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let at_zero = gradient_of(row, free[row.bodies.x], free[row.bodies.y]);
        let scaled = at_zero + (gradient - at_zero) * factor;
        own.x = length(residual_term(z, gradient, row));
        own.y = length(residual_term(z * factor, scaled, row));
        if ROLLS {
            let own_roll = roll[k].xyz;
            let before = roll_gradient(free[row.bodies.x], free[row.bodies.y]);
            let now = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
            let turning = before + (now - before) * factor;
            let lever = sqrt(roll_row[k].w);
            own.x += lever * length(roll_term(own_roll, now, row, z, roll_row[k]));
            own.y += lever * length(roll_term(own_roll * factor, turning, row, z * factor, roll_row[k]));
        }
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
