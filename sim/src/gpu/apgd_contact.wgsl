// APGD, a trial: z = Π(y − t η (N y + r)) from y = x + β (x − previous). If the last trial was taken, it is x now.
// in    row       [n_contacts]
// in    motion_y  [n_bodies]    m/s, rad/s: velocities that y gives the bodies
// inout gamma     [n_contacts]  N s, world: x, previous and z, four numbers each of which the last is not used
// out   moved     [n_contacts]  |z − y|²/η, J
// out   slope     [n_contacts]  (N y + r)·(z − x), J
// in    scalars   [1]
// in    count     [1]           n_contacts
// Twin: cpu/solve/apgd.rs
#import sphere
#import project
#import apgd_scalars

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion_y: array<Body>;
@group(0) @binding(2) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> previous: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> next: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> moved: array<f32>;
@group(0) @binding(6) var<storage, read_write> slope: array<f32>;
@group(0) @binding(7) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(8) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    var x = gamma[k].xyz;
    var before = previous[k].xyz;
    if scalars[0].accepted != 0u {
        before = x;
        x = next[k].xyz;
        previous[k] = vec4(before, 0.0);
        gamma[k] = vec4(x, 0.0);
    }
    let row = rows[k];
    let y = x + (x - before) * scalars[0].beta;
    let gradient = gradient_of(row, motion_y[row.bodies.x], motion_y[row.bodies.y]);
    let z = project(y - gradient * (scalars[0].step * row.eta), row.normal, row.friction);
    next[k] = vec4(z, 0.0);
    moved[k] = dot(z - y, z - y) / row.eta;
    slope[k] = dot(gradient, z - x);
}
