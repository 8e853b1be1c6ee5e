// What is nearest at samples before anything is there.
// out  nearest  [n_samples]  id, which is none, and the key of the greatest depth
// in   params   [1]          count of samples

@group(0) @binding(0) var<storage, read_write> nearest: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k < params[0] {
        nearest[k] = vec2<u32>(0u, 0xff800000u);
    }
}
