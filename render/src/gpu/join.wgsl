// Layers of one primitive that are in one place become one, where grids meet as far as their depths may differ there;
// and so do those of faces of a mesh that are met on an edge that they share. What repeats another has no id any more.
// in    ends    [n]         where the list of a sample ends
// inout layers  [n_layers]  key of the depth, and id; none of what repeats another
// in    params  [16]        those of `layered`, as far as these
// Twin: cpu/samples/layers.rs, cpu/samples.rs
#import layer_lists
#import layer_repeats

// Layers that one loop goes through.
const RUN: u32 = 32768u;

fn grid_of_layer(id: u32) -> u32 {
    return grid_of(micropolygons[(id & ID) >> 1u]);
}

// Let a layer be one with the last before it that is of its mesh, if that is near; no depths differ by more than `most` at sides of grids.
fn join(sample: u32, first: u32, at: u32, tolerance: f32, again: bool, most: f32) {
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
        let apart = z - depth_of(before.x);
        if apart > rounded(tolerance * z) + most {
            return;
        }
        if before.y == NONE || grids[grid_of_layer(before.y)].w != whole {
            continue;
        }
        let before_waits = (before.y & AT_RIM) != 0u && (again || (before.y & JOINED) == 0u);
        let waits = (v.y & AT_RIM) != 0u && (again || (v.y & JOINED) == 0u);
        let is_near = apart <= rounded(tolerance * z) || is_within_slack(sample, before, v, tolerance);
        if is_near && (before_waits || waits) {
            layers[at].y = NONE;
            layers[k - 1u].y |= JOINED;
        }
        return;
    }
}

fn join_all(sample: u32, first: u32, end: u32, tolerance: f32, again: bool, most: f32) {
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            join(sample, first, at, tolerance, again, most);
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
    let sample = params[13] + k;
    // How far depths of one surface may differ at sides of grids, at most.
    var most = 0.0;
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            if (layers[at].y & AT_SIDE) != 0u {
                most = max(most, slack_of(sample, layers[at].y));
            }
        }
    }
    most = 2.0 * most;
    var any_at_rim = false;
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            let layer = layers[at];
            let grid = grid_of_layer(layer.y);
            let primitive = grids[grid].x;
            if repeats(first, at, depth_of(layer.x), primitive)
                || ((layer.y & AT_SIDE) != 0u && repeats_at_side(sample, first, at, primitive, most)) {
                layers[at].y = NONE;
            } else if grids[grid].w != 0u && (layer.y & AT_RIM) != 0u {
                any_at_rim = true;
            }
        }
    }
    if any_at_rim {
        join_all(sample, first, end, COINCIDENT, true, most);
        join_all(sample, first, end, SAME, false, most);
    }
    for (var run = first; run < end; run += RUN) {
        for (var at = run; at < min(end, run + RUN); at += 1u) {
            if layers[at].y != NONE {
                layers[at].y &= ID;
            }
        }
    }
}
