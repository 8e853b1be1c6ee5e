// The greatest depth in blocks of 4 by 4 pixels, a block an invocation.
// Twin: cpu/samples/cull.rs

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let block = (group.x + group.y * 65535u) * 64u + thread;
    if block >= params[3] {
        return;
    }
    let columns = (params[0] + 3u) / 4u;
    let corner = 4u * vec2<u32>(block % columns, block / columns);
    let end = min(corner + 4u, vec2<u32>(params[0], params[1]));
    var greatest = 0u;
    for (var y = corner.y; y < end.y; y += 1u) {
        let first = (y * params[0] + corner.x) * params[2];
        let last = (y * params[0] + end.x) * params[2];
        for (var k = first; k < last; k += 1u) {
            greatest = max(greatest, depth_at(k));
        }
    }
    block_depth[block] = greatest;
}
