// What displays take, besides colours, of what is visible at samples.
// in    visible         [n_samples]    ids of what is visible and has no colour yet
// in    outputs         [n × points]
// out   sample_outputs  [n × samples]
// in    params          [14]           those of samples, 13 of them, and n
// Twin: cpu/samples/visible.rs
#import within

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    if k >= params[2] * params[3] * params[4] * params[5] || visible[k] == 0xffffffffu {
        return;
    }
    let n = params[13];
    let m = micropolygons[visible[k] >> 1u];
    let is_second = (visible[k] & 1u) != 0u;
    var w = vec3<f32>(1.0, 0.0, 0.0);
    if (m.z & 1u) != 0u {
        let others_of = weights_at(k, m, is_second);
        w = within(vec3<f32>(1.0 - others_of.x - others_of.y, others_of));
    }
    let at = others(m, is_second);
    for (var i = 0u; i < n; i += 1u) {
        // What is the same at all corners stays that to the bit.
        let a = outputs[m.x * n + i];
        let own = a + (outputs[at.x * n + i] - a) * w.y + (outputs[at.y * n + i] - a) * w.z;
        sample_outputs[k * n + i] = select(own, 0.0, (m.z & 2u) != 0u);
    }
}
