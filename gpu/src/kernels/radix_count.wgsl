// Count the 256 values of an 8-bit digit in each block of 4096 keys.
// in    keys    [n]
// out   place   [256 x n_blocks]  digit-major, so that a prefix sum over it gives every block's place for every digit
// in    count   [1]               n
// in    params  [1]               the digit's lowest bit
// Twin: radix_sort.rs, sort_cpu
#import radix_block
#import key

@group(0) @binding(0) var<storage, read> keys: array<Key>;
@group(0) @binding(1) var<storage, read_write> place: array<u32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

var<workgroup> histogram: array<atomic<u32>, 256>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let n = count[0];
    let block = block_of(group);
    let first = block * RADIX_BLOCK + thread;
    for (var i = 0u; i < KEYS; i++) {
        if first + i * THREADS < n {
            atomicAdd(&histogram[digit_of(keys[first + i * THREADS], params[0])], 1u);
        }
    }
    workgroupBarrier();
    let n_blocks = radix_blocks(n);
    if block < n_blocks {
        place[thread * n_blocks + block] = atomicLoad(&histogram[thread]);
    }
}
