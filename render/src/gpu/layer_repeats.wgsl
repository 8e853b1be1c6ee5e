// Which layers repeat one of their primitive.
// Twin: cpu/samples/layers.rs

// What one primitive's layers are apart at least at sides of grids, as a part of their depth; elsewhere; the id of none.
const SAME: f32 = 1e-4;
const COINCIDENT: f32 = 2e-6;
const NONE: u32 = 0xffffffffu;

// Whether a layer repeats one of its primitive before it.
fn repeats(first: u32, at: u32, z: f32, primitive: u32) -> bool {
    for (var k = at; k > first; k -= 1u) {
        let before = layers[k - 1u];
        if z - depth_of(before.x) > rounded(COINCIDENT * z) {
            return false;
        }
        if before.y != NONE && grids[grid_of_layer(before.y)].x == primitive {
            return true;
        }
    }
    return false;
}

fn slack_of(sample: u32, id: u32) -> f32 {
    return slack_at(sample, micropolygons[(id & ID) >> 1u], (id & 1u) != 0u);
}

// Whether the depths of two layers, of which one is before the other, differ by no more than they may where both are met at sides of grids.
fn is_within_slack(sample: u32, before: vec2<u32>, v: vec2<u32>, part: f32) -> bool {
    if (before.y & v.y & AT_SIDE) == 0u {
        return false;
    }
    let z = depth_of(v.x);
    let slack = rounded(slack_of(sample, before.y) + slack_of(sample, v.y));
    return z - depth_of(before.x) <= rounded(part * z) + slack;
}

// Whether a layer that is met at a side of its grid repeats the last of its primitive before it that is so, too; no depths differ by more than
// `most` there.
fn repeats_at_side(sample: u32, first: u32, at: u32, primitive: u32, most: f32) -> bool {
    let v = layers[at];
    let z = depth_of(v.x);
    for (var k = at; k > first; k -= 1u) {
        let before = layers[k - 1u];
        if z - depth_of(before.x) > rounded(SAME * z) + most {
            return false;
        }
        if before.y == NONE || (before.y & AT_SIDE) == 0u || grids[grid_of_layer(before.y)].x != primitive {
            continue;
        }
        return is_within_slack(sample, before, v, SAME);
    }
    return false;
}
