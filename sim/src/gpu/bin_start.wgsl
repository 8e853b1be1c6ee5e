// Find the range of each bin among the sorted spheres.
// in    bin        [n_spheres]  sorted
// inout bin_start  [n_bins]     first sphere of the bin in the sorted column, and the end; zeros in
// in    count      [1]          n_spheres if pairs are to be found, else 0
// Twin: cpu/bin_start.rs
#import sphere

@group(0) @binding(0) var<storage, read> bin: array<u32>;
@group(0) @binding(1) var<storage, read_write> bin_start: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = row_of(group, thread);
    if i >= count[0] || bin[i] >= arrayLength(&bin_start) {
        return;
    }
    if i == 0u || bin[i - 1u] != bin[i] {
        bin_start[bin[i]].x = i;
    }
    if i + 1u == count[0] || bin[i + 1u] != bin[i] {
        bin_start[bin[i]].y = i + 1u;
    }
}
