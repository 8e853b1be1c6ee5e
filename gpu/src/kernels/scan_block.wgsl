// Exclusive prefix sum within each block of 1024, and each block's sum.
// inout values  [n]         counts in, prefix sums within the block out
// out   sums    [n_blocks]  sum of the block
// in    count   [1]         number of values of level 0
// in    params  [1]         level
// Twin: scan.rs, exclusive_cpu
#import block
#import group_sum

@group(0) @binding(0) var<storage, read_write> values: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, lane: Lane) {
    let n = values_of_level(count[0], params[0]);
    let block = block_of(group);
    let thread = thread_of(lane);
    let first = block * BLOCK + thread * PER_THREAD;
    var own: array<u32, 4>;
    var sum = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        own[i] = sum;
        if first + i < n {
            sum += values[first + i];
        }
    }
    let prefix = group_sum(lane, sum);
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < n {
            values[first + i] = prefix.x + own[i];
        }
    }
    if thread == 0u && block < arrayLength(&sums) {
        sums[block] = prefix.y;
    }
}
