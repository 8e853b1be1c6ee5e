// The colour of a sample between those of the corners of the triangle that it sees.
// Twin: cpu/samples/visible.rs
#import within

// The colour of a micropolygon's triangle, by the weights of its second and third corner.
fn mixed(m: vec4<u32>, is_second: bool, second: f32, third: f32) -> vec4<f32> {
    let w = within(vec3<f32>(1.0 - second - third, second, third));
    let at = others(m, is_second);
    return vec4<f32>(colors[m.x].xyz * w.x + colors[at.x].xyz * w.y + colors[at.y].xyz * w.z, 1.0);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    if k >= params[2] * params[3] * params[4] * params[5] || visible[k] == 0xffffffffu {
        return;
    }
    let m = micropolygons[visible[k] >> 1u];
    var found = vec4<f32>();
    if (m.z & 3u) == 1u {
        let is_second = (visible[k] & 1u) != 0u;
        let w = weights_at(k, m, is_second);
        found = mixed(m, is_second, w.x, w.y);
    } else if (m.z & 2u) == 0u {
        found = vec4<f32>(colors[m.x].xyz, 1.0);
    }
    color[k] = found;
    visible[k] = 0xffffffffu;
}
