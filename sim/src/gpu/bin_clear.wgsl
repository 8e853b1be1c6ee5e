// No spheres in any bin.
// out  bin_start  [n_bins]  first sphere of the bin in the sorted column, and the end
// in   count      [1]       n_bins if pairs are to be found, else 0
#import sphere

@group(0) @binding(0) var<storage, read_write> bin_start: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b < count[0] {
        bin_start[b] = vec2(0u);
    }
}
