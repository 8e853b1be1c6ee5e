// Which layers a sample has: not those behind what is opaque, nor those that are clipped or of a level of detail that it does not see.

// A number from 0 to 1 of a sample's own: the samples of a pixel have numbers that are evenly spread, in an order of its own.
fn part_of(sample: u32) -> f32 {
    let n = vec2<u32>(params[4], params[5]);
    let stratum = min(vec2<u32>(in_pixel(sample) * vec2<f32>(n)), n - 1u);
    let pixel = pixel_of_sample(sample);
    let hash = (((pixel.x * 0x9e3779b1u) ^ (pixel.y * 0x85ebca77u)) * 0xc2b2ae3du) >> 12u;
    let rank = ((stratum.y * n.x + stratum.x) * params[15] + hash) % (n.x * n.y);
    return (f32(rank) + 0.5) / f32(n.x * n.y);
}

// The value of a plane's three numbers at a place.
fn at_place(f: vec4<f32>, at: vec2<f32>) -> f32 {
    return rounded(rounded(f.x * at.x) + rounded(f.y * at.y)) + f.z;
}

fn is_clipped(sample: u32, z: f32) -> bool {
    let at = vec2<f32>(bitcast<vec2<i32>>(pixel_of_sample(sample))) + in_pixel(sample);
    for (var k = 0u; k < params[16]; k += 1u) {
        if rounded(at_place(planes[2u * k], at) * z) + at_place(planes[2u * k + 1u], at) > 0.0 {
            return true;
        }
    }
    return false;
}

fn is_layer(sample: u32, key: u32, id: u32) -> bool {
    if sample < params[13] || sample >= params[14] || key >= depth[sample] {
        return false;
    }
    let seen = bitcast<vec2<f32>>(grids[grid_of(micropolygons[(id & ID) >> 1u]) + 1u].xy);
    if any(seen != vec2<f32>(0.0, 1.0)) {
        let part = part_of(sample);
        if part < seen.x || part >= seen.y {
            return false;
        }
    }
    return params[16] == 0u || !is_clipped(sample, depth_of(key));
}
