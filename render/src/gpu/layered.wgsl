// Layers of samples: which micropolygons are layers at a sample, and what is asked of them.
// in   micropolygons  [n_micropolygons]  first point, points of a row, what it is, as raster.wgsl has it, and 16 times the first row of its
//                                        grid, track
// in   grids          [n_rows]           of a grid: name of its primitive, count of its points, count of the times at which it is shaded again, one
//                                        more than the name of its mesh, 0 if it shares none; the part of the samples that see it, as bits, its
//                                        first point, and which of its sides are edges of the primitive, a bit each; then these times, four a row
// in   params         [18]               those of samples, 13 of them; then the first sample and the one after the last, the step of samples in
//                                        their order, count of clipping planes, numbers of a sample's outputs
// Twin: cpu/samples.rs, cpu/samples/layers.rs

// The depth of a key.
fn depth_of(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key ^ 0x80000000u, (key & 0x80000000u) != 0u));
}

fn grid_of(m: vec4<u32>) -> u32 {
    return m.z >> 4u;
}

fn pixel_of_sample(sample: u32) -> vec2<u32> {
    let n = params[4] * params[5];
    return vec2<u32>(params[0], params[1]) + vec2<u32>(sample / n % params[2], sample / n / params[2]);
}

// The place of a sample in its pixel.
fn in_pixel(sample: u32) -> vec2<f32> {
    let n = vec2<u32>(params[4], params[5]);
    let at = pixel_of_sample(sample) & vec2<u32>(31u);
    let k = sample % (n.x * n.y);
    return offsets[(at.y * n.y + k / n.x) * 32u * n.x + at.x * n.x + k % n.x];
}
