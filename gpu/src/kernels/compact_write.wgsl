// Write the ids of the values that are kept, in order, and their number.
// in   place  [n + 1]  prefix sums of the flags
// out  ids    [n_kept]
// out  n_kept [1]
// in   count  [1]      n
// Twin: compact.rs, compact_cpu
#import block

@group(0) @binding(0) var<storage, read> place: array<u32>;
@group(0) @binding(1) var<storage, read_write> ids: array<u32>;
@group(0) @binding(2) var<storage, read_write> n_kept: array<u32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let n = count[0];
    for (var i = 0u; i < PER_THREAD; i++) {
        let k = block_of(group) * BLOCK + i * THREADS + thread;
        if k < n && place[k] != place[k + 1u] {
            ids[place[k]] = k;
        }
        if k == 0u {
            n_kept[0] = place[n];
        }
    }
}
