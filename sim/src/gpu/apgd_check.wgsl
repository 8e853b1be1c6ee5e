// APGD: residual terms of the iterate x squared, summed over a workgroup.
// in   row      [n_contacts]
// in   motion   [n_bodies]    m/s, rad/s: velocities with x
// in   x        [n_contacts or twice as many]  N s, world: the half that has it
// in   next     [n_contacts]  N s, world: x, if the last trial was taken
// in   scalars  [1]
// out  parts    [n_groups]    m²/s², and the same of what is rounding
// in   count    [1]           n_contacts
// in    roll_x, roll_next  N m s, world: the same of rolling and spinning impulses
// in    roll_row [n_contacts]
// Twin: cpu/solve/iterates.rs
#import sphere
#import project
#import residual_term
#import scalars
#import partial
#import roll

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> x_column: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> next: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(5) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> roll_x: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> roll_next: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> roll_row: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let row = rows[k];
        let x = select(x_column[k + scalars[0].half * (arrayLength(&x_column) / 2u)].xyz, next[k].xyz, scalars[0].accepted != 0u);
        let gradient = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        let term = residual_term(x, gradient, row);
        own.x = dot(term, term);
        own.y = rounding_of(row, motion[row.bodies.x], motion[row.bodies.y]);
        if ROLLS {
            let own_roll = select(roll_x[k + scalars[0].half * (arrayLength(&roll_x) / 2u)].xyz, roll_next[k].xyz, scalars[0].accepted != 0u);
            let turning = roll_gradient(motion[row.bodies.x], motion[row.bodies.y]);
            let of_roll = roll_term(own_roll, turning, row, x, roll_row[k]);
            own.x += dot(of_roll, of_roll) * roll_row[k].w;
        }
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
