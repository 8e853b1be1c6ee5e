// Feed the slips that were measured back to the rates of the gaps.
// inout row    [n_contacts]
// inout slip   [n_contacts]  m/s: the offset without slip, the slip that is fed, the next one
// in    count  [1]           n_contacts
// Twin: cpu/solve/exact.rs
#import sphere
#import solve_row

@group(0) @binding(0) var<storage, read_write> rows: array<Row>;
@group(0) @binding(1) var<storage, read_write> slip: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] {
        slip[k].y = slip[k].z;
        rows[k].offset = slip[k].x + slip[k].z;
    }
}
