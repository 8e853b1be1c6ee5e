// Layers of faces of a mesh that are met on an edge that they share become one, as those of one primitive that are very near to each other do:
// what repeats another has no id any more.
// in    ends    [n]         where the list of a sample ends
// inout layers  [n_layers]  key of the depth, and id; none of what repeats another
// in    params  [16]        those of `layered`, as far as these
// Twin: cpu/samples/layers.rs, cpu/samples.rs
#import layer_lists
#import layer_repeats

// The same of what is met at one depth, but for rounding.
const COINCIDENT: f32 = 2e-6;

// The weight of the corner over against an edge, below which a sample lies on that edge; and that of a corner from which on a sample lies at it.
const ON_EDGE: f32 = 1e-3;
const AT_CORNER: f32 = 0.95;

// What is known of a layer, beside its id: it lies on an edge of its primitive; another face was met with it.
const AT_RIM: u32 = 0x80000000u;
const JOINED: u32 = 0x40000000u;
const ID: u32 = 0x3fffffffu;

// Layers that one loop goes through.
const RUN: u32 = 32768u;

fn grid_of_layer(id: u32) -> u32 {
    return grid_of(micropolygons[(id & ID) >> 1u]);
}

// Whether a place in a triangle of a micropolygon lies on an edge of the primitive.
fn is_at_rim(sample: u32, id: u32) -> bool {
    let m = micropolygons[id >> 1u];
    let rims = grids[grid_of(m) + 1u].w;
    let k = m.x - grids[grid_of(m) + 1u].z;
    let i = k % m.y;
    let j = k / m.y;
    let low_u = (rims & 1u) != 0u && i == 0u;
    let high_u = (rims & 2u) != 0u && i + 2u == m.y;
    let low_v = (rims & 4u) != 0u && j == 0u;
    let high_v = (rims & 8u) != 0u && j + 2u == grids[grid_of(m)].y / m.y;
    if !(low_u || high_u || low_v || high_v) {
        return false;
    }
    let is_second = (id & 1u) != 0u;
    let w = weights_at(sample, m, is_second);
    let first = 1.0 - w.x - w.y;
    // Over against the first corner and the third; of the second triangle against the first and the second.
    let on_edge = (first <= ON_EDGE && select(high_u, high_v, is_second))
        || (select(w.y, w.x, is_second) <= ON_EDGE && select(low_v, low_u, is_second));
    let across = select(w.x, w.y, is_second);
    let far = select(w.y, w.x, is_second);
    // Beyond the diagonal, at a corner that it ends in, the edges of the other triangle are as near.
    let at_corner = (first >= AT_CORNER && (low_u || low_v)) || (far >= AT_CORNER && (high_u || high_v));
    return on_edge || (across <= 0.0 && at_corner);
}

// Let a layer be one with the last before it that is of its mesh, if that is near.
fn join(first: u32, at: u32, tolerance: f32, again: bool) {
    let v = layers[at];
    if v.y == NONE {
        return;
    }
    let whole = grids[grid_of_layer(v.y)].w;
    if whole == 0u {
        return;
    }
    let z = depth_of(v.x);
    for (var k = at; k > first; k -= 1u) {
        let before = layers[k - 1u];
        if z - depth_of(before.x) > rounded(tolerance * z) {
            return;
        }
        if before.y == NONE || grids[grid_of_layer(before.y)].w != whole {
            continue;
        }
        let before_waits = (before.y & AT_RIM) != 0u && (again || (before.y & JOINED) == 0u);
        let waits = (v.y & AT_RIM) != 0u && (again || (v.y & JOINED) == 0u);
        if before_waits || waits {
            layers[at].y = NONE;
            layers[k - 1u].y |= JOINED;
        }
        return;
    }
}

fn join_all(first: u32, end: u32, tolerance: f32, again: bool) {
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            join(first, at, tolerance, again);
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    if k >= params[14] - params[13] {
        return;
    }
    let first = first_layer(k);
    let end = ends[k];
    if end - first < 2u {
        return;
    }
    var any_at_rim = false;
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            let layer = layers[at];
            let grid = grid_of_layer(layer.y);
            let is_of_mesh = grids[grid].w != 0u;
            if repeats(first, at, depth_of(layer.x), grids[grid].x) {
                layers[at].y = NONE;
            } else if is_of_mesh && is_at_rim(params[13] + k, layer.y) {
                layers[at].y |= AT_RIM;
                any_at_rim = true;
            }
        }
    }
    if !any_at_rim {
        return;
    }
    join_all(first, end, COINCIDENT, true);
    join_all(first, end, SAME, false);
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            if layers[at].y != NONE {
                layers[at].y &= ID;
            }
        }
    }
}
