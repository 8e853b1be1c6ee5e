// Spectral projected gradients: the trial z = Π(x − α η (N x + r)), from the velocities that x gives the bodies.
// in    row       [n_contacts]
// in    motion    [n_bodies]    m/s, rad/s: velocities with x
// in    x         [n_contacts]  N s, world; the fourth numbers are not used
// out   next      [n_contacts]  N s, world: z
// out   parts     [n_groups]    |z − x|²/η and (N x + r)·(z − x), J, summed over a workgroup
// in    scalars   [1]
// in    count     [1]           n_contacts
// in    roll_x    [n_contacts]  N m s, world: rolling and spinning impulses on B
// out   roll_next [n_contacts]  N m s, world
// in    roll_row  [n_contacts]
// out   spin     [n_contacts]  what z turns the bodies by, as in `spin.wgsl`
// Twin: cpu/solve/barzilai_borwein.rs
#import sphere
#import project
#import scalars
#import partial
#import roll
#import leave_spin

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> x_column: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> next: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> roll_x: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> roll_next: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> spin: array<vec4<f32>>;

// The trial of the rolling impulse of a contact with the impulse x, and what it adds to the sums.
fn roll_trial(k: u32, row: Row, gamma: vec3<f32>) -> vec4<f32> {
    let of_roll = roll_row[k];
    let x = roll_x[k].xyz;
    let gradient = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
    let z = project_roll(x - gradient * (scalars[0].omega * of_roll.z), row, gamma, of_roll);
    roll_next[k] = vec4(z, 0.0);
    return vec4(dot(z - x, z - x) / of_roll.z, dot(gradient, z - x), 0.0, 0.0);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let x = x_column[k].xyz;
        let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let z = project_row(x - gradient * (scalars[0].omega * row.eta), row);
        next[k] = with_arm(row, z);
        leave_spin(k, row, z);
        own = vec4(dot(z - x, z - x) / row.eta, dot(gradient, z - x), 0.0, 0.0);
        if ROLLS {
            own += roll_trial(k, row, x);
        }
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
