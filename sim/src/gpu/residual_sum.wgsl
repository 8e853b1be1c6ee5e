// The residual of the solution.
// in    parts    [n_groups]  residual terms squared, m²/s²
// inout scalars  [1]
// in    count    [1]         n_contacts
#import scalars
#import parts_total

@group(0) @binding(0) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let n_parts = groups_of(count[0]);
    let sums = parts_total(thread, n_parts);
    if thread == 0u {
        scalars[0].residual = sqrt(sums.x) / f32(max(blocks_of(count[0]), 1u));
    }
}
