// Sum each segment of up to 64 values, in order; list the longer ones.
// in   values   [n]
// in   start    [n_segments + 1]  first value of each segment, and the end
// out  sums     [n_segments]
// out  long     [n_long]          longer segments, in any order
// inout n_long  [1]               zero in
// in   count    [1]               n_segments
// Twin: segments.rs, sums_cpu
#import block

const LONG: u32 = 64u;

@group(0) @binding(0) var<storage, read> values: array<f32>;
@group(0) @binding(1) var<storage, read> start: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<f32>;
@group(0) @binding(3) var<storage, read_write> long: array<u32>;
@group(0) @binding(4) var<storage, read_write> n_long: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let segment = block_of(group) * THREADS + thread;
    if segment >= count[0] {
        return;
    }
    let first = start[segment];
    let length = start[segment + 1u] - first;
    if length > LONG {
        long[atomicAdd(&n_long[0], 1u)] = segment;
        return;
    }
    var sum = 0.0;
    for (var k = 0u; k < length; k++) {
        sum += values[first + k];
    }
    sums[segment] = sum;
}
