// The change of all slips, and their sum.
// in   parts  [n_groups]  m/s: |change|, slip
// out  sums   [1]
// in   count  [1]         n_contacts
#import partial

@group(0) @binding(0) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var own = vec4(0.0);
    for (var i = thread; i < groups_of(count[0]); i += 256u) {
        own += parts[i];
    }
    own = group_total(thread, own);
    if thread == 0u {
        sums[0] = own;
    }
}
