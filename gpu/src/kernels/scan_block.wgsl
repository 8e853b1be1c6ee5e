// Exclusive prefix sum within each block of 1024, and each block's sum.
// inout values  [n]         counts in, prefix sums within the block out
// out   sums    [n_blocks]  sum of the block
// in    size    [1]         n
// Twin: scan.rs, exclusive_cpu
#import block

@group(0) @binding(0) var<storage, read_write> values: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
@group(0) @binding(2) var<storage, read> size: array<u32>;

var<workgroup> partial: array<u32, THREADS>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let block = block_of(group);
    let first = block * BLOCK + thread * PER_THREAD;
    var own: array<u32, 4>;
    var sum = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        own[i] = sum;
        if first + i < size[0] {
            sum += values[first + i];
        }
    }
    partial[thread] = sum;
    for (var step = 1u; step < THREADS; step <<= 1u) {
        workgroupBarrier();
        var left = 0u;
        if thread >= step {
            left = partial[thread - step];
        }
        workgroupBarrier();
        partial[thread] += left;
    }
    workgroupBarrier();
    let before = partial[thread] - sum;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < size[0] {
            values[first + i] = before + own[i];
        }
    }
    if thread == THREADS - 1u && block < arrayLength(&sums) {
        sums[block] = partial[thread];
    }
}
