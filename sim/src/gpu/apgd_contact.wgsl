// APGD, a trial: z = Π(y − t η (N y + r)) from y = x + β (x − previous). If the last trial was taken, it is x now, in the place of the iterate
// before the last.
// in    row       [n_contacts]
// in    motion_y  [n_bodies]    m/s, rad/s: velocities that y gives the bodies
// inout x         [2 n_contacts]  N s, world; the fourth numbers are not used; the half that has it, and the other, which has the one before it
// inout next      [n_contacts]  N s, world: z
// out   parts     [n_groups]    |z − y|²/η and (N y + r)·(z − x), J, summed over a workgroup
// in    scalars   [1]
// in    count     [1]           n_contacts
// inout roll_x    [2 n_contacts]  N m s, world: the same of rolling and spinning impulses
// inout roll_next [n_contacts]
// in    roll_row [n_contacts]
// out   spin     [n_contacts]  what z turns the bodies by, as in `spin.wgsl`
// Twin: cpu/solve/apgd.rs
#import sphere
#import project
#import scalars
#import partial
#import roll
#import leave_spin

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion_y: array<Body>;
@group(0) @binding(2) var<storage, read_write> x_column: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> next: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read_write> roll_x: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> roll_next: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> spin: array<vec4<f32>>;

// The rows of a contact in a column of `n` rows: that of x, and that of the iterate before it; without extrapolation, as at first, it is not asked for.
fn rows_of(k: u32, n: u32) -> vec2<u32> {
    let of_x = k + scalars[0].half * (n / 2u);
    return vec2(of_x, select(k + (1u - scalars[0].half) * (n / 2u), of_x, scalars[0].beta == 0.0));
}

// The trial of the rolling impulse of a contact with the impulse x, and what it adds to the sums.
fn roll_trial(k: u32, row: Row, gamma: vec3<f32>) -> vec4<f32> {
    let at = rows_of(k, arrayLength(&roll_x));
    let before = roll_x[at.y].xyz;
    var x: vec3<f32>;
    if scalars[0].accepted != 0u {
        x = roll_next[k].xyz;
        roll_x[at.x] = vec4(x, 0.0);
    } else {
        x = roll_x[at.x].xyz;
    }
    let of_roll = roll_row[k];
    let y = x + (x - before) * scalars[0].beta;
    let gradient = roll_gradient(motion_y[row.bodies.x], motion_y[row.bodies.y]);
    let z = project_roll(y - gradient * (scalars[0].step * of_roll.z), row, gamma, of_roll);
    roll_next[k] = vec4(z, 0.0);
    return vec4(dot(z - y, z - y) / of_roll.z, dot(gradient, z - x), 0.0, 0.0);
}

// The trial of a contact, if there is such a one. Returns what it adds to the sums.
fn trial_of(k: u32) -> vec4<f32> {
    if k >= count[0] {
        return vec4(0.0);
    }
    let at = rows_of(k, arrayLength(&x_column));
    let before = x_column[at.y].xyz;
    var x: vec3<f32>;
    if scalars[0].accepted != 0u {
        x = next[k].xyz;
        x_column[at.x] = vec4(x, 0.0);
    } else {
        x = x_column[at.x].xyz;
    }
    let row = rows[k];
    let y = x + (x - before) * scalars[0].beta;
    let gradient = gradient_of(row, motion_y[row.bodies.x], motion_y[row.bodies.y]);
    let z = project_row(y - gradient * (scalars[0].step * row.eta), row);
    next[k] = with_arm(row, z);
    leave_spin(k, row, z);
    var own = vec4(dot(z - y, z - y) / row.eta, dot(gradient, z - x), 0.0, 0.0);
    if ROLLS {
        own += roll_trial(k, row, x);
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
        let sum = group_total(thread, trial_of(block * 256u + thread));
        if thread == 0u {
            parts[block] = sum;
        }
    }
}
