// What is nearest at samples, as depths and ids; it is no longer to be coloured.
// inout nearest  [n_samples]  1 more than the id, 0 if there is none; and the key of the depth
// out   depth    [n_samples]  the key of the depth
// out   visible  [n_samples]  the id of what is visible and has no colour yet; all bits are none
// in    params   [1]          count of samples

@group(0) @binding(0) var<storage, read_write> nearest: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> depth: array<u32>;
@group(0) @binding(2) var<storage, read_write> visible: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 256u + thread;
    if k < params[0] {
        let own = nearest[k];
        depth[k] = own.y;
        visible[k] = own.x - 1u;
        nearest[k] = vec2<u32>(0u, own.y);
    }
}
