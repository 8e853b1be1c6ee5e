// Copy rows of 16 bytes.
// in   rows    [n]
// out  copy    [n]
// in   params  [1]  n
#import block

@group(0) @binding(0) var<storage, read> rows: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copy: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    for (var i = 0u; i < PER_THREAD; i++) {
        let k = block_of(group) * BLOCK + i * THREADS + thread;
        if k < params[0] {
            copy[k] = rows[k];
        }
    }
}
