// Filtering of what displays take besides colours: colours by all samples, other values by those that are covered; the least depth, and the
// id at the middle of a pixel.
// in   color           [n_samples]         colour and coverage
// in   offsets         [32 × 32 × strata]  places of samples in their pixels
// in   table           [n]                 the filter's values, as `filter` has them
// in   depth           [n_samples]         the key of the depth
// in   kinds           [n]                 of each number: 0, 1 to 3 of a colour, 8 more if it counts by the opacity, 4 the depth, 5 the id
// in   sample_outputs  [n × samples]
// out  pixels          [n × pixels]        of the inner part
// in   params          [13]                those of `filter`, and n
// Twin: cpu/samples/pixels.rs
#import filter_weight

@group(0) @binding(0) var<storage, read> color: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> offsets: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> table: array<f32>;
@group(0) @binding(3) var<storage, read> depth: array<u32>;
@group(0) @binding(4) var<storage, read> kinds: array<u32>;
@group(0) @binding(5) var<storage, read> sample_outputs: array<f32>;
@group(0) @binding(6) var<storage, read_write> pixels: array<f32>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

// The place of a sample in its pixel.
fn offset_of(x: u32, y: u32, s: u32) -> vec2<f32> {
    let strata = vec2<u32>(params[4], params[5]);
    let at = (vec2<u32>(params[0], params[1]) + vec2<u32>(x, y)) & vec2<u32>(31u);
    return offsets[(at.y * strata.y + s / strata.x) * 32u * strata.x + at.x * strata.x + s % strata.x];
}

fn depth_of(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key ^ 0x80000000u, (key & 0x80000000u) != 0u));
}

// The least depth of the covered samples of a pixel.
fn nearest(first: u32, n: u32) -> f32 {
    var least = 0xff800000u;
    for (var s = 0u; s < n; s += 1u) {
        if color[first + s].w > 0.0 {
            least = min(least, depth[first + s]);
        }
    }
    return depth_of(least);
}

// The sample nearest the middle of a pixel, if it is covered: its number.
fn at_middle(x: u32, y: u32, first: u32, n: u32, i: u32) -> f32 {
    var least = 1e30;
    var middle = 0u;
    for (var s = 0u; s < n; s += 1u) {
        let off = offset_of(x, y, s) - 0.5;
        let far = off.x * off.x + off.y * off.y;
        if far < least {
            least = far;
            middle = s;
        }
    }
    return select(0.0, sample_outputs[(first + middle) * params[12] + i], color[first + middle].w > 0.0);
}

fn filtered(middle: vec2<u32>, i: u32) -> f32 {
    let margin = vec2<u32>(params[6], params[7]);
    let n = params[4] * params[5];
    var sum = 0.0;
    var all = 0.0;
    for (var y = middle.y - margin.y; y <= middle.y + margin.y; y += 1u) {
        for (var x = middle.x - margin.x; x <= middle.x + margin.x; x += 1u) {
            let from_middle = vec2<f32>(vec2<i32>(vec2<u32>(x, y)) - vec2<i32>(middle)) - 0.5;
            let first = (y * params[2] + x) * n;
            for (var s = 0u; s < n; s += 1u) {
                let w = weight(from_middle + offset_of(x, y, s));
                if w != 0.0 {
                    sum += w * sample_outputs[(first + s) * params[12] + i];
                    all += select(0.0, w, kinds[i] > 0u || color[first + s].w > 0.0);
                }
            }
        }
    }
    return select(0.0, sum / all, all != 0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    let margin = vec2<u32>(params[6], params[7]);
    let inner = vec2<u32>(params[2], params[3]) - 2u * margin;
    let pixel = k / params[12];
    if pixel >= inner.x * inner.y {
        return;
    }
    let i = k % params[12];
    let middle = vec2<u32>(pixel % inner.x, pixel / inner.x) + margin;
    let n = params[4] * params[5];
    let first = (middle.y * params[2] + middle.x) * n;
    if kinds[i] == 4u {
        pixels[k] = nearest(first, n);
    } else if kinds[i] == 5u {
        pixels[k] = at_middle(middle.x, middle.y, first, n, i);
    } else {
        pixels[k] = filtered(middle, i);
    }
}
