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
    let grid = tracks[m.w];
    var key = 0u;
    for (var next = 1u; next < tracks[m.w + 1u].x; next += 1u) {
        if moment.x >= bitcast<f32>(tracks[grid.w + next].x) {
            key = next;
        }
    }
    let met = meet_at(track_of(m, key, bitcast<vec4<f32>>(tracks[grid.w + key])), place_of(pixel, sample % n), moment);
    return met.weights.yz;
}
