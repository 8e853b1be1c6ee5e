// One for each value that is kept, so that a prefix sum gives its place.
// in   flags  [n]      other than zero where the value is kept
// out  place  [n + 1]  zero at the end
// out  n_place [1]     n + 1
// in   count  [1]      n
// Twin: compact.rs, compact_cpu
#import block

@group(0) @binding(0) var<storage, read> flags: array<u32>;
@group(0) @binding(1) var<storage, read_write> place: array<u32>;
@group(0) @binding(2) var<storage, read_write> n_place: array<u32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let n = count[0];
    for (var i = 0u; i < PER_THREAD; i++) {
        let k = block_of(group) * BLOCK + i * THREADS + thread;
        if k < n {
            place[k] = select(0u, 1u, flags[k] != 0u);
        }
        if k == 0u {
            place[n] = 0u;
            n_place[0] = n + 1u;
        }
    }
}
