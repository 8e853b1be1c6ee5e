// Whether any contact has an impulse to start from.
// in    gamma  [n_contacts]  N s, world
// inout flag   [1]           zero in
// in    count  [1]           n_contacts
#import sphere

@group(0) @binding(0) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> flag: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] && any(gamma[k].xyz != vec3(0.0)) {
        atomicStore(&flag[0], 1u);
    }
}
