// Add to each block of 1024 the sum of all blocks before it.
// inout values  [n]         prefix sums within the block in, of the whole out
// in    before  [n_blocks]  sum of the blocks before
// in    count   [1]         number of values of level 0
// in    params  [1]         level
// Twin: scan.rs, exclusive_cpu
#import block

@group(0) @binding(0) var<storage, read_write> values: array<u32>;
@group(0) @binding(1) var<storage, read> before: array<u32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let n = values_of_level(count[0], params[0]);
    let block = block_of(group);
    for (var i = 0u; i < PER_THREAD; i++) {
        let k = block * BLOCK + i * THREADS + thread;
        if k < n {
            values[k] += before[block];
        }
    }
}
