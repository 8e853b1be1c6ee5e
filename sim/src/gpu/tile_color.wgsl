// Colour the pairs of each tile, a workgroup for each: pairs of one colour have no moving body in common. The pairs are put into the order
// of their colours, and the moving bodies of the tile are listed. Colours do not depend on the order in which threads run: in each round a
// pair that comes first among those of both of its bodies, by a number drawn from its place, takes the least colour that these have free.
// A tile of too many pairs, bodies or colours is big: its pairs stay as they are.
// in   sorted      [n_pairs]    in the order of tiles
// in   sphere      [n_spheres]
// in   fixture     [n_fixtures]
// in   activity    [n_bodies]
// in   tile_first  [n_tiles]    first pair of each tile
// in   n_tiles     [1]
// in   n_pairs     [1]
// in   round_start [10]         first tile of each round
// out  pairs       [n_pairs]    in the order of tiles and colours
// out  color       [n_pairs]
// out  local       [n_pairs]    places of the two bodies in the tile's list, 16 bits each; all ones for one that is held
// out  tile_body   [2 n_pairs]  bodies of each tile, from twice its first pair on
// out  tile_size   [n_tiles]    number of bodies, and of colours
// out  is_big      [n_tiles]
// in   params      [3]          the most bodies of a tile that is not big, the index of this dispatch, and the number of dispatches
// Twin: cpu/solve/schedule.rs
#import sphere
#import fixture

@group(0) @binding(0) var<storage, read> sorted: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> activity: array<u32>;
@group(0) @binding(4) var<storage, read> tile_first: array<u32>;
@group(0) @binding(5) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(6) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(7) var<storage, read> round_start: array<u32>;
@group(0) @binding(8) var<storage, read_write> pairs: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> color: array<u32>;
@group(0) @binding(10) var<storage, read_write> local: array<u32>;
@group(0) @binding(11) var<storage, read_write> tile_body: array<u32>;
@group(0) @binding(12) var<storage, read_write> tile_size: array<vec2<u32>>;
@group(0) @binding(13) var<storage, read_write> is_big: array<u32>;
@group(0) @binding(14) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;
// The most pairs of a tile that is not big, four to a thread, and its colours.
const MOST: u32 = 1024u;
const MOST_COLORS: u32 = 32u;
const SLOTS: u32 = 1024u;
const NONE: u32 = 0xffffffffu;

// A table of bodies: the body of each slot; the pair that claims it, and the colours that it has. Once all pairs have theirs, the rows of
// `claim` are the colours of the pairs, and those of `taken` the places of the bodies in the list.
var<workgroup> body_in: array<atomic<u32>, 1024>;
var<workgroup> claim: array<atomic<u32>, 1024>;
var<workgroup> taken: array<atomic<u32>, 1024>;
var<workgroup> n_bodies: atomic<u32>;
var<workgroup> n_listed: atomic<u32>;
var<workgroup> n_left: atomic<u32>;
var<workgroup> left: u32;
// Number of pairs of each colour.
var<workgroup> n_of_color: array<atomic<u32>, 33>;
var<workgroup> has_failed: atomic<u32>;

fn body_of(side: u32) -> u32 {
    let n = arrayLength(&sphere);
    if side >= n {
        return fixture[side - n].body;
    }
    return sphere[side].body;
}

// The slot of a body that moves, entered if it is not there; none for one that is held, or where there are too many.
fn slot_of(body: u32) -> u32 {
    if activity[body] != MOVING {
        return NONE;
    }
    var slot = (body * 0x9e3779b1u) >> 22u;
    for (var i = 0u; i < SLOTS; i++) {
        let found = atomicCompareExchangeWeak(&body_in[slot], NONE, body);
        if found.exchanged {
            atomicAdd(&n_bodies, 1u);
            return slot;
        }
        if found.old_value == body {
            return slot;
        }
        // A weak exchange may fail for no reason: the slot is tried again.
        if found.old_value != NONE {
            slot = (slot + 1u) & (SLOTS - 1u);
        }
    }
    atomicStore(&has_failed, 1u);
    return NONE;
}

// A number drawn from the place of a pair, another for each.
fn drawn(k: u32) -> u32 {
    return (((k * 0x2c1b3c6du) >> 12u) << 10u) | k;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tile = (group.x + group.y * 65535u) * params[2] + params[1];
    if tile >= n_tiles[0] {
        return;
    }
    let first = tile_first[tile];
    let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
    let n = end - first;
    if n > MOST || tile >= round_start[8] {
        for (var k = thread; k < n; k += THREADS) {
            pairs[first + k] = sorted[first + k];
        }
        if thread == 0u {
            is_big[tile] = 1u;
        }
        return;
    }
    for (var s = thread; s < SLOTS; s += THREADS) {
        atomicStore(&body_in[s], NONE);
        atomicStore(&claim[s], NONE);
        atomicStore(&taken[s], 0u);
    }
    if thread == 0u {
        atomicStore(&n_bodies, 0u);
        atomicStore(&n_listed, 0u);
        atomicStore(&has_failed, 0u);
        left = 1u;
    }
    if thread < 33u {
        atomicStore(&n_of_color[thread], 0u);
    }
    workgroupBarrier();
    var slots: array<vec2<u32>, 4>;
    var own: array<u32, 4>;
    for (var i = 0u; i < 4u; i++) {
        let k = i * THREADS + thread;
        own[i] = select(NONE - 1u, NONE, k < n);
        if k < n {
            slots[i] = vec2(slot_of(body_of(sorted[first + k].x)), slot_of(body_of(sorted[first + k].y)));
        }
    }
    workgroupBarrier();
    if thread == 0u && atomicLoad(&n_bodies) > params[0] {
        atomicStore(&has_failed, 1u);
    }
    // Each round colours one pair at least.
    for (var round = 0u; round <= MOST; round++) {
        workgroupBarrier();
        if workgroupUniformLoad(&left) == 0u {
            break;
        }
        if thread == 0u {
            atomicStore(&n_left, 0u);
        }
        for (var i = 0u; i < 4u; i++) {
            if own[i] == NONE {
                let number = drawn(i * THREADS + thread);
                if slots[i].x != NONE {
                    atomicMin(&claim[slots[i].x], number);
                }
                if slots[i].y != NONE {
                    atomicMin(&claim[slots[i].y], number);
                }
            }
        }
        workgroupBarrier();
        var mine = vec4(false);
        for (var i = 0u; i < 4u; i++) {
            if own[i] == NONE {
                let number = drawn(i * THREADS + thread);
                var is_first = true;
                var used = 0u;
                if slots[i].x != NONE {
                    is_first = atomicLoad(&claim[slots[i].x]) == number;
                    used = atomicLoad(&taken[slots[i].x]);
                }
                if slots[i].y != NONE {
                    is_first = is_first && atomicLoad(&claim[slots[i].y]) == number;
                    used |= atomicLoad(&taken[slots[i].y]);
                }
                mine[i] = is_first;
                if is_first {
                    own[i] = select(firstTrailingBit(~used), MOST_COLORS, used == NONE);
                }
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < 4u; i++) {
            if mine[i] {
                let bit = select(1u << (own[i] % 32u), 0u, own[i] == MOST_COLORS);
                if slots[i].x != NONE {
                    atomicOr(&taken[slots[i].x], bit);
                }
                if slots[i].y != NONE {
                    atomicOr(&taken[slots[i].y], bit);
                }
            }
            if mine[i] || own[i] == NONE {
                if slots[i].x != NONE {
                    atomicStore(&claim[slots[i].x], NONE);
                }
                if slots[i].y != NONE {
                    atomicStore(&claim[slots[i].y], NONE);
                }
            }
            if own[i] == NONE {
                atomicAdd(&n_left, 1u);
            }
        }
        workgroupBarrier();
        if thread == 0u {
            left = atomicLoad(&n_left);
        }
    }
    for (var i = 0u; i < 4u; i++) {
        let k = i * THREADS + thread;
        if k < n {
            atomicStore(&claim[k], own[i]);
            atomicAdd(&n_of_color[own[i]], 1u);
            if own[i] == MOST_COLORS {
                atomicStore(&has_failed, 1u);
            }
        }
    }
    for (var s = thread; s < SLOTS; s += THREADS) {
        let body = atomicLoad(&body_in[s]);
        if body != NONE {
            let place = atomicAdd(&n_listed, 1u);
            atomicStore(&taken[s], place);
            tile_body[2u * first + place] = body;
        }
    }
    workgroupBarrier();
    if atomicLoad(&has_failed) == 1u {
        for (var k = thread; k < n; k += THREADS) {
            pairs[first + k] = sorted[first + k];
        }
        if thread == 0u {
            is_big[tile] = 1u;
        }
        return;
    }
    for (var i = 0u; i < 4u; i++) {
        let k = i * THREADS + thread;
        if k < n {
            // Behind the pairs of lower colours, and those of its own before it.
            var to = first;
            for (var j = 0u; j < n; j++) {
                let other = atomicLoad(&claim[j]);
                to += u32(other < own[i] || (other == own[i] && j < k));
            }
            pairs[to] = sorted[first + k];
            color[to] = own[i];
            local[to] = local_of(slots[i].x) | (local_of(slots[i].y) << 16u);
        }
    }
    if thread == 0u {
        var n_colors = 0u;
        for (var c = 0u; c < MOST_COLORS; c++) {
            n_colors += u32(atomicLoad(&n_of_color[c]) > 0u);
        }
        tile_size[tile] = vec2(atomicLoad(&n_bodies), n_colors);
        is_big[tile] = 0u;
    }
}

fn local_of(slot: u32) -> u32 {
    if slot == NONE {
        return 0xffffu;
    }
    return atomicLoad(&taken[slot]);
}
