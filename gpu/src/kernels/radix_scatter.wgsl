// Move keys and their values to their places for one 4-bit digit; keys of equal digit keep their order.
// in    keys, values          [n]
// in    place                 [16 x n_blocks]  first place of each digit of each block
// out   keys_out, values_out  [n]
// in    pass_                 [3]              n, n_blocks, the digit's lowest bit
// Twin: radix_sort.rs, sort_cpu
#import block

@group(0) @binding(0) var<storage, read> keys: array<u32>;
@group(0) @binding(1) var<storage, read> values: array<u32>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys_out: array<u32>;
@group(0) @binding(4) var<storage, read_write> values_out: array<u32>;
@group(0) @binding(5) var<storage, read> pass_: array<u32>;

// How many keys of each digit the threads up to this one hold: [digit][thread], 16 KiB.
var<workgroup> tally: array<u32, 4096>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let block = block_of(group);
    let first = block * BLOCK + thread * PER_THREAD;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < pass_[0] {
            tally[((keys[first + i] >> pass_[2]) & 15u) * THREADS + thread] += 1u;
        }
    }
    workgroupBarrier();
    // Each of the first 16 threads sums its digit's row; the other way round would need 16 scans.
    if thread < 16u {
        var sum = 0u;
        for (var t = 0u; t < THREADS; t++) {
            let own = tally[thread * THREADS + t];
            tally[thread * THREADS + t] = sum;
            sum += own;
        }
    }
    workgroupBarrier();
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < pass_[0] {
            let key = keys[first + i];
            let digit = (key >> pass_[2]) & 15u;
            let slot = digit * THREADS + thread;
            let to = place[digit * pass_[1] + block] + tally[slot];
            tally[slot] += 1u;
            keys_out[to] = key;
            values_out[to] = values[first + i];
        }
    }
}
