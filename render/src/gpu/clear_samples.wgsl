// Samples before anything is there.
// out  depth    [n_samples]  the key of the greatest depth
// out  visible  [n_samples]  none
// out  color    [n_samples]  no colour and no coverage
// in   params   [1]          count of samples

@group(0) @binding(0) var<storage, read_write> depth: array<u32>;
@group(0) @binding(1) var<storage, read_write> visible: array<u32>;
@group(0) @binding(2) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k < params[0] {
        depth[k] = 0xff800000u;
        visible[k] = 0xffffffffu;
        color[k] = vec4<f32>();
    }
}
