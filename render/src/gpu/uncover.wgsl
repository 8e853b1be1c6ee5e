// Between the passes: what is no longer nearest at a sample is not visible there.
// in    depth    [n_samples]  the key of the depth of what is nearest
// in    before   [n_samples]  the same before the first pass
// inout visible  [n_samples]  the id of what is visible; all bits are none
// in    params   [1]          count of samples

@group(0) @binding(0) var<storage, read> depth: array<u32>;
@group(0) @binding(1) var<storage, read> before: array<u32>;
@group(0) @binding(2) var<storage, read_write> visible: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k < params[0] && depth[k] < before[k] {
        visible[k] = 0xffffffffu;
    }
}
