// The pixel filter: what a sample counts at a place from the middle of a pixel.
// Twin: film/filter.rs

fn along(axis: u32, x: f32) -> f32 {
    let at = abs(x);
    if at >= bitcast<f32>(params[8u + axis]) {
        return 0.0;
    }
    return table[select(0u, params[10], axis == 1u) + u32(at * 256.0)];
}

fn weight(d: vec2<f32>) -> f32 {
    if params[11] == 1u {
        return 1.0;
    }
    if params[11] == 2u {
        let ratio = bitcast<f32>(params[8]) / bitcast<f32>(params[9]);
        return along(0u, sqrt(d.x * d.x + d.y * d.y * ratio * ratio));
    }
    if params[11] == 3u {
        let r = sqrt(d.x * d.x + d.y * d.y);
        let is_within = abs(d.x) < bitcast<f32>(params[8]) && abs(d.y) < bitcast<f32>(params[9]) && r < 2.0;
        return select(0.0, table[min(u32(r * 256.0), params[10] - 1u)], is_within);
    }
    return along(0u, d.x) * along(1u, d.y);
}
