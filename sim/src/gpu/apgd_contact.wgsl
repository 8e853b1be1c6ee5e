// APGD, a trial: z = Π(y − t η (N y + r)) from y = x + β (x − previous). If the last trial was taken, it is x now.
// in    row       [n_contacts]
// in    motion_y  [n_bodies]    m/s, rad/s: velocities that y gives the bodies
// inout x         [n_contacts]  N s, world; the fourth numbers are not used
// inout previous  [n_contacts]  N s, world
// inout next      [n_contacts]  N s, world: z
// out   parts     [n_groups]    |z − y|²/η and (N y + r)·(z − x), J, summed over a workgroup
// in    scalars   [1]
// in    count     [1]           n_contacts
// Twin: cpu/solve/apgd.rs
#import sphere
#import project
#import scalars
#import partial

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion_y: array<Body>;
@group(0) @binding(2) var<storage, read_write> x_column: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> previous: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> next: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(7) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        var x = x_column[k].xyz;
        var before = previous[k].xyz;
        if scalars[0].accepted != 0u {
            before = x;
            x = next[k].xyz;
            previous[k] = vec4(before, 0.0);
            x_column[k] = vec4(x, 0.0);
        }
        let row = rows[k];
        let y = x + (x - before) * scalars[0].beta;
        let gradient = gradient_of(row, motion_y[row.bodies.x], motion_y[row.bodies.y]);
        let z = project(y - gradient * (scalars[0].step * row.eta), row.normal, row.friction);
        next[k] = vec4(z, 0.0);
        own = vec4(dot(z - y, z - y) / row.eta, dot(gradient, z - x), 0.0, 0.0);
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
