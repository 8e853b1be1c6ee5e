// Where a sample meets a triangle of a micropolygon that moves or is out of focus, and its time.

fn moment_of(sample: u32) -> vec4<f32> {
    let n = params[4] * params[5];
    let pixel = vec2<u32>(sample / n % params[2], sample / n / params[2]);
    return moments[(1024u + in_pattern(pixel)) * n + sample % n];
}

fn time_of(sample: u32) -> f32 {
    return moment_of(sample).x;
}

// The weights of the second and the third corner.
fn weights_at(sample: u32, m: vec4<u32>, is_second: bool) -> vec2<f32> {
    let n = params[4] * params[5];
    let pixel = vec2<u32>(sample / n % params[2], sample / n / params[2]);
    let moment = moment_of(sample);
    let t = track_at(m, moment.x);
    return met_in(t, moment, corners_at(t, place_of(pixel, sample % n), moment), is_second).weights.yz;
}
