// Number of contacts with an impulse, and the sum over them of slip speeds, or of the impulses on the second of two classes; of each workgroup.
// in   rows    [n_contacts]
// in   motion  [n_bodies]    m/s, rad/s
// in   gamma   [n_contacts]  N s, world: impulses on B
// in   class_of [n_bodies]
// in   count   [1]           n_contacts
// out  parts   [n_groups]    m/s or N s; the number
// in   params  [3]           whether two classes are meant, and these
// Twin: probe.rs
#import sphere
#import project
#import partial

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> class_of: array<u32>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

fn slip_of(row: Row) -> vec3<f32> {
    let velocity = gradient_of(row, motion[row.bodies.x], motion[row.bodies.y]);
    return vec3(length(velocity - row.normal * dot(velocity, row.normal)), 0.0, 0.0);
}

// The sum and the number of a contact.
fn terms_of(k: u32) -> vec4<f32> {
    let z = gamma[k].xyz;
    if k >= count[0] || all(z == vec3(0.0)) {
        return vec4(0.0);
    }
    let row = rows[k];
    if params[0] == 0u {
        return vec4(slip_of(row), 1.0);
    }
    let classes = vec2(class_of[row.bodies.x], class_of[row.bodies.y]);
    if all(classes == vec2(params[1], params[2])) {
        return vec4(z, 1.0);
    }
    if all(classes == vec2(params[2], params[1])) {
        return vec4(-z, 1.0);
    }
    return vec4(0.0);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    let sum = group_total(thread, terms_of(k));
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
