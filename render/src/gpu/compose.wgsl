// Composition: the layers of a sample, nearest first, over what is opaque there.
// in    colors     [n_points]   colours of points, by their opacity
// in    opacities  [n_points]
// in    ends       [n]          where the list of a sample ends
// in    layers     [n_layers]   key of the depth, and id; none of what repeats another
// inout depth      [n_samples]  the key of the depth of what is opaque; then of what is half opaque
// inout color      [n_samples]  colour and coverage
// out   visible    [n_samples]  the id of what is nearest and lets nothing through at any corner, if that is a layer
// Twin: cpu/samples/layers.rs
#import within
#import layer_lists

// The id of none.
const NONE: u32 = 0xffffffffu;

// The light that counts as none.
const CLOSED: f32 = 9.094947e-13;
// The opacity from which on a layer counts as what is visible.
const OPAQUE: f32 = 0.999999;

// What layers have come to.
struct Sum {
    n: u32,
    color: vec3<f32>,
    open: vec3<f32>,
    alpha: vec3<f32>,
    // Depth of the first, of the last, and of the first that is half opaque; whether there is such a one.
    first_z: f32,
    z: f32,
    half_z: f32,
    is_half: bool,
}

// A layer's triangle at a sample: its corners among the points, what they count, and how many points on they are again as shaded later, and
// the part of the way to that.
struct Seen {
    corners: vec3<u32>,
    weights: vec3<f32>,
    next: u32,
    part: f32,
    is_matte: bool,
}

fn seen_at(sample: u32, id: u32, m: vec4<u32>) -> Seen {
    let is_second = (id & 1u) != 0u;
    var seen = Seen(vec3<u32>(m.x, others(m, is_second)), vec3<f32>(1.0, 0.0, 0.0), 0u, 0.0, (m.z & 2u) != 0u);
    if (m.z & 1u) != 0u {
        let w = weights_at(sample, m, is_second);
        seen.weights = within(vec3<f32>(1.0 - w.x - w.y, w));
    }
    let grid = grids[grid_of(m)];
    if grid.z > 0u {
        let time = time_of(sample);
        var k = 0u;
        while k + 1u < grid.z && fade_time(m, k) < time {
            k += 1u;
        }
        var before = 0.0;
        if k > 0u {
            before = fade_time(m, k - 1u);
        }
        seen.corners += vec3<u32>(k * grid.y);
        seen.next = grid.y;
        seen.part = clamp((time - before) / (fade_time(m, k) - before), 0.0, 1.0);
    }
    return seen;
}

fn fade_time(m: vec4<u32>, k: u32) -> f32 {
    return bitcast<f32>(grids[grid_of(m) + 2u + k / 4u][k % 4u]);
}

fn color_at(seen: Seen, point: u32) -> vec3<f32> {
    let now = colors[point].xyz;
    return now + (colors[point + seen.next].xyz - now) * seen.part;
}

fn opacity_at(seen: Seen, point: u32) -> vec3<f32> {
    let now = opacities[point].xyz;
    return now + (opacities[point + seen.next].xyz - now) * seen.part;
}

fn is_closed(open: vec3<f32>) -> bool {
    return all(abs(open) < vec3<f32>(CLOSED));
}

// Lay a layer behind those of a sum; whether its corners let nothing through.
fn lay(sum: ptr<function, Sum>, k: u32, sample: u32, id: u32, m: vec4<u32>, z: f32) -> bool {
    let seen = seen_at(sample, id, m);
    let w = seen.weights;
    let a = opacity_at(seen, seen.corners.x);
    var is_opaque = all(a >= vec3<f32>(OPAQUE));
    var opacity = a;
    var found = color_at(seen, seen.corners.x);
    if (m.z & 1u) != 0u {
        let b = opacity_at(seen, seen.corners.y);
        let c = opacity_at(seen, seen.corners.z);
        is_opaque = is_opaque && all(min(b, c) >= vec3<f32>(OPAQUE));
        opacity = a * w.x + b * w.y + c * w.z;
        found = found * w.x + color_at(seen, seen.corners.y) * w.y + color_at(seen, seen.corners.z) * w.z;
    }
    opacity = clamp(opacity, vec3<f32>(), vec3<f32>(1.0));
    let is_half = (opacity.x + opacity.y + opacity.z) / 3.0 >= 0.5;
    lay_outputs(*sum, k, seen, opacity, is_half && !(*sum).is_half);
    if !seen.is_matte {
        (*sum).color += (*sum).open * found;
        (*sum).alpha += (*sum).open * opacity;
    }
    (*sum).open *= 1.0 - opacity;
    if is_half && !(*sum).is_half {
        (*sum).half_z = z;
        (*sum).is_half = true;
    }
    if (*sum).n == 0u {
        (*sum).first_z = z;
    }
    (*sum).z = z;
    (*sum).n += 1u;
    return is_opaque;
}

fn compose(k: u32) {
    let sample = params[13] + k;
    let first = first_layer(k);
    let end = ends[k];
    visible[sample] = NONE;
    if first == end {
        return;
    }
    var sum: Sum;
    sum.open = vec3<f32>(1.0);
    for (var run = first; run < end; run += 32768u) {
        for (var at = run; at < min(end, run + 32768u); at += 1u) {
            let layer = layers[at];
            if layer.y == NONE {
                continue;
            }
            let z = depth_of(layer.x);
            // What is equally deep is one layer.
            if sum.n > 0u && z != sum.z && is_closed(sum.open) {
                break;
            }
            let m = micropolygons[layer.y >> 1u];
            if lay(&sum, k, sample, layer.y, m, z) && visible[sample] == NONE {
                visible[sample] = layer.y;
            }
        }
    }
    let closed = is_closed(sum.open);
    finish_outputs(sum, k, sample, closed);
    let under = select(color[sample], vec4<f32>(), closed);
    let alpha = sum.alpha + sum.open * under.w;
    color[sample] = vec4<f32>(sum.color + sum.open * under.xyz, (alpha.x + alpha.y + alpha.z) / 3.0);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    if k < params[14] - params[13] {
        compose(k);
    }
}
