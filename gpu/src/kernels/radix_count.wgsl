// Count the 16 values of a 4-bit digit in each block of 1024 keys.
// in    keys   [n]
// out   count  [16 x n_blocks]  digit-major, so that a prefix sum over it gives every block's place for every digit
// in    pass_  [3]              n, n_blocks, the digit's lowest bit
// Twin: radix_sort.rs, sort_cpu
#import block

@group(0) @binding(0) var<storage, read> keys: array<u32>;
@group(0) @binding(1) var<storage, read_write> count: array<u32>;
@group(0) @binding(2) var<storage, read> pass_: array<u32>;

var<workgroup> histogram: array<atomic<u32>, 16>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let block = block_of(group);
    let first = block * BLOCK + thread * PER_THREAD;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < pass_[0] {
            atomicAdd(&histogram[(keys[first + i] >> pass_[2]) & 15u], 1u);
        }
    }
    workgroupBarrier();
    if thread < 16u && block < pass_[1] {
        count[thread * pass_[1] + block] = atomicLoad(&histogram[thread]);
    }
}
