// The samples that meet a micropolygon, one micropolygon an invocation: `take` is told of each, with the key of its depth, which rises
// with the depth, and the id of the triangle.
// Twin: cpu/still.rs

fn sample_micropolygon(index: u32) {
    let m = micropolygons[index];
    let q = quad(m);
    let low = min(min(q.b.xy, q.c.xy), min(q.d.xy, vec2<f32>())) - EDGE;
    let high = max(max(q.b.xy, q.c.xy), max(q.d.xy, vec2<f32>())) + EDGE;
    // With some room for rounding.
    let least = q.a.xy + low - EDGE;
    let most = q.a.xy + high + EDGE;
    let size = vec2<f32>(f32(params[2]), f32(params[3]));
    if !(most.x >= 0.0 && most.y >= 0.0 && least.x < size.x && least.y < size.y) {
        return;
    }
    let strata = vec2<u32>(params[4], params[5]);
    let first = triangle(q.a.z, q.b, q.c, q.side);
    let second = triangle(q.a.z, q.c, q.d, q.side);
    let start = vec2<u32>(max(least, vec2<f32>()) * vec2<f32>(strata));
    let end = min(vec2<u32>(min(most, size) * vec2<f32>(strata)) + 1u, vec2<u32>(params[2], params[3]) * strata);
    for (var y = start.y; y < end.y; y += 1u) {
        for (var x = start.x; x < end.x; x += 1u) {
            let pixel = vec2<u32>(x, y) / strata;
            let stratum = vec2<u32>(x, y) % strata;
            let d = place(pixel, stratum) - q.a.xy;
            if d.x < low.x || d.y < low.y || d.x > high.x || d.y > high.y {
                continue;
            }
            let p = meet(first, d);
            let r = meet(second, d);
            if !p.inside && !r.inside {
                continue;
            }
            let choice = choose(m, q, d, p, r);
            if !choice.is_met {
                continue;
            }
            let sample = (pixel.y * params[2] + pixel.x) * strata.x * strata.y + stratum.y * strata.x + stratum.x;
            take(sample, key_of(select(p.z, r.z, choice.is_second)), (2u * index + u32(choice.is_second)) | choice.flags);
        }
    }
}
