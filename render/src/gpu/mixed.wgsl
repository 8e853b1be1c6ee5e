// The colour of a sample between those of the corners of the triangle that it sees.
// Twin: cpu/samples/visible.rs

// Weights of a point of a triangle; of one on the widened edge, those of a point inside nearby.
fn within(w: vec3<f32>) -> vec3<f32> {
    if all(w >= vec3<f32>()) {
        return w;
    }
    let inside = max(w, vec3<f32>());
    return inside / (inside.x + inside.y + inside.z);
}

// The colour of a micropolygon's triangle, by the weights of its second and third corner.
fn mixed(m: vec4<u32>, is_second: bool, second: f32, third: f32) -> vec4<f32> {
    let w = within(vec3<f32>(1.0 - second - third, second, third));
    let a = colors[m.x].xyz;
    let across = colors[m.x + m.y + 1u].xyz;
    if is_second {
        return vec4<f32>(a * w.x + across * w.y + colors[m.x + m.y].xyz * w.z, 1.0);
    }
    return vec4<f32>(a * w.x + colors[m.x + 1u].xyz * w.y + across * w.z, 1.0);
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
        found = smooth_color(k, m, (visible[k] & 1u) != 0u);
    } else if (m.z & 2u) == 0u {
        found = vec4<f32>(colors[m.x].xyz, 1.0);
    }
    color[k] = found;
    visible[k] = 0xffffffffu;
}
