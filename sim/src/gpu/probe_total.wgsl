// A sum over the contacts, from those of workgroups.
// in    parts   [n_groups]
// in    count   [1]        n_contacts
// inout sums    [n_sums]
// in    params  [1]        the place of the sum
#import parts_total

@group(0) @binding(0) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> count: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let sum = parts_total(thread, groups_of(count[0]));
    if thread == 0u {
        sums[params[0]] = sum;
    }
}
