// Where a sample meets a triangle of a micropolygon that stands still, and its time.

// The weights of the second and the third corner.
fn weights_at(sample: u32, m: vec4<u32>, is_second: bool) -> vec2<f32> {
    let strata = vec2<u32>(params[4], params[5]);
    let n = strata.x * strata.y;
    let pixel = vec2<u32>(sample / n % params[2], sample / n / params[2]);
    let q = quad(m);
    let d = place(pixel, vec2<u32>(sample % n % strata.x, sample % n / strata.x)) - q.a.xy;
    if is_second {
        let p = meet(triangle(q.a.z, q.c, q.d, q.side), d);
        return vec2<f32>(p.second, p.third);
    }
    let p = meet(triangle(q.a.z, q.b, q.c, q.side), d);
    return vec2<f32>(p.second, p.third);
}

fn time_of(sample: u32) -> f32 {
    return 0.0;
}
