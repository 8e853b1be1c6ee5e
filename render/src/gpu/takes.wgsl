// A micropolygon an invocation, and the key of a depth, which rises with the depth.

fn key_of(z: f32) -> u32 {
    let bits = bitcast<u32>(z);
    return bits ^ select(0x80000000u, 0xffffffffu, (bits & 0x80000000u) != 0u);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    // One without points of a row is not there.
    if k < params[8] && micropolygons[params[7] + k].y != 0u {
        sample_micropolygon(params[7] + k);
    }
}
