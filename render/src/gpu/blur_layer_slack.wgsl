// By how much the depth of a layer that moves or is out of focus may differ from that of one that is the same.

fn slack_at(sample: u32, m: vec4<u32>, is_second: bool) -> f32 {
    let n = params[4] * params[5];
    let pixel = vec2<u32>(sample / n % params[2], sample / n / params[2]);
    let moment = moment_of(sample);
    let t = track_at(m, moment.x);
    let at = corners_at(t, place_of(pixel, sample % n), moment);
    return slack_in(around(m, at[0], at[1], at[2], at[3]), is_second, t.z0 + rounded4(t.z1 * moment.x));
}
