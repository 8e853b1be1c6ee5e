// Filtering of samples to pixels.
// in   color    [n_samples]          colour and coverage
// in   offsets  [32 × 32 × strata]   places of samples in their pixels
// in   table    [n]                  the filter's values along x, then along y, 256 a pixel from its centre on
// out  pixels   [n_pixels]           of the inner part
// in   params   [12]                 first pixel's column and row; width and height; strata along x and y; margins along x and y; half
//                                    widths along x and y, as bits; values along x; 1 if it is a box of a pixel, 2 if it is of the distance
//                                    in half widths, 3 if it is of that in pixels
// Twin: cpu/samples/pixels.rs
#import filter_weight

@group(0) @binding(0) var<storage, read> color: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> offsets: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> table: array<f32>;
@group(0) @binding(3) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    let margin = vec2<u32>(params[6], params[7]);
    let inner = vec2<u32>(params[2], params[3]) - 2u * margin;
    if k >= inner.x * inner.y {
        return;
    }
    let strata = vec2<u32>(params[4], params[5]);
    let middle = vec2<u32>(k % inner.x, k / inner.x) + margin;
    let first = vec2<u32>(params[0], params[1]);
    var sum = vec4<f32>();
    var all = 0.0;
    for (var y = middle.y - margin.y; y <= middle.y + margin.y; y += 1u) {
        for (var x = middle.x - margin.x; x <= middle.x + margin.x; x += 1u) {
            let at = (first + vec2<u32>(x, y)) & vec2<u32>(31u);
            let from_middle = vec2<f32>(vec2<i32>(vec2<u32>(x, y)) - vec2<i32>(middle)) - 0.5;
            let sample = (y * params[2] + x) * strata.x * strata.y;
            for (var s = 0u; s < strata.x * strata.y; s += 1u) {
                let offset = offsets[(at.y * strata.y + s / strata.x) * 32u * strata.x + at.x * strata.x + s % strata.x];
                let w = weight(from_middle + offset);
                if w != 0.0 {
                    sum += w * color[sample + s];
                    all += w;
                }
            }
        }
    }
    pixels[k] = select(vec4<f32>(), sum / all, all != 0.0);
}
