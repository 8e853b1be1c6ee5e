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
    if any(start >= end) {
        return;
    }
    // Pixel and stratum go on with the sample: to divide for each would take as long as its test.
    let first_pixel = start / strata;
    let first_stratum = start % strata;
    let pattern = vec2<u32>(corner(params[0], params[1]));
    var pixel_y = first_pixel.y;
    var stratum_y = first_stratum.y;
    for (var y = start.y; y < end.y; y += 1u) {
        let offsets_of_row = (((pattern.y + pixel_y) & 31u) * strata.y + stratum_y) * 32u * strata.x;
        let samples_of_row = pixel_y * params[2] * strata.x * strata.y + stratum_y * strata.x;
        var pixel_x = first_pixel.x;
        var stratum_x = first_stratum.x;
        for (var x = start.x; x < end.x; x += 1u) {
            let at = offsets_of_row + ((pattern.x + pixel_x) & 31u) * strata.x + stratum_x;
            let d = vec2<f32>(vec2<u32>(pixel_x, pixel_y)) + offsets[at] - q.a.xy;
            let sample = samples_of_row + pixel_x * strata.x * strata.y + stratum_x;
            stratum_x += 1u;
            if stratum_x == strata.x {
                stratum_x = 0u;
                pixel_x += 1u;
            }
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
            take(sample, key_of(select(p.z, r.z, choice.is_second)), (2u * index + u32(choice.is_second)) | choice.flags);
        }
        stratum_y += 1u;
        if stratum_y == strata.y {
            stratum_y = 0u;
            pixel_y += 1u;
        }
    }
}
