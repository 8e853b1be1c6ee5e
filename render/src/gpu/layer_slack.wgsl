// By how much the depth of a layer that stands still may differ from that of one that is the same.

fn slack_at(sample: u32, m: vec4<u32>, is_second: bool) -> f32 {
    let strata = vec2<u32>(params[4], params[5]);
    let n = strata.x * strata.y;
    let pixel = vec2<u32>(sample / n % params[2], sample / n / params[2]);
    let q = quad(m);
    let d = place(pixel, vec2<u32>(sample % n % strata.x, sample % n / strata.x)) - q.a.xy;
    let v = around(m, -d, q.b.xy - d, q.c.xy - d, q.d.xy - d);
    return slack_in(v, is_second, vec4<f32>(q.a.z, q.a.z + q.b.z, q.a.z + q.c.z, q.a.z + q.d.z));
}
