// Sum the long segments, a workgroup each: every 256th value in order, then the 256 sums as a binary tree, neighbours first.
// in   values  [n]
// in   start   [n_segments + 1]  first value of each segment, and the end
// out  sums    [n_segments]
// in   long    [n_long]          the segments
// in   n_long  [1]
// Twin: segments.rs, sums_cpu
#import block
#import group_tree

@group(0) @binding(0) var<storage, read> values: array<f32>;
@group(0) @binding(1) var<storage, read> start: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<f32>;
@group(0) @binding(3) var<storage, read> long: array<u32>;
@group(0) @binding(4) var<storage, read> n_long: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, lane: Lane) {
    let k = block_of(group);
    let is_segment = k < n_long[0];
    let segment = select(0u, long[k], is_segment);
    let end = select(0u, start[segment + 1u], is_segment);
    var sum = 0.0;
    for (var i = start[segment] + thread_of(lane); i < end; i += THREADS) {
        sum += values[i];
    }
    let result = group_tree(lane, sum);
    if is_segment && thread_of(lane) == 0u {
        sums[segment] = result;
    }
}
