// List the moving bodies of each tile, a workgroup for each, and where each pair has its own in the list. A tile of too many pairs or bodies
// is big: it is not listed.
// in   sorted      [n_pairs]    in the order of tiles
// in   sphere      [n_spheres]
// in   fixture     [n_fixtures]
// in   activity    [n_bodies]
// in   tile_first  [n_tiles]    first pair of each tile
// in   n_tiles     [1]
// in   n_pairs     [1]
// in   round_start [10]         first tile of each round
// out  pairs       [n_pairs]    in the order of tiles
// out  local       [n_pairs]    places of the two bodies in the tile's list, 16 bits each; all ones for one that is held
// out  tile_body   [2 n_pairs]  bodies of each tile, from twice its first pair on
// out  tile_size   [n_tiles]    number of bodies
// out  is_big      [n_tiles]
// in   params      [4]          the index of this dispatch, the number of dispatches, and that of the rounds whose tiles are swept by workgroups of
//                               their own; the most bodies of a tile in those after the first
// Twin: cpu/solve/schedule.rs
#import side
#import tile_most

@group(0) @binding(0) var<storage, read> sorted: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> activity: array<u32>;
@group(0) @binding(4) var<storage, read> tile_first: array<u32>;
@group(0) @binding(5) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(6) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(7) var<storage, read> round_start: array<u32>;
@group(0) @binding(8) var<storage, read_write> pairs: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> local: array<u32>;
@group(0) @binding(10) var<storage, read_write> tile_body: array<u32>;
@group(0) @binding(11) var<storage, read_write> tile_size: array<vec2<u32>>;
@group(0) @binding(12) var<storage, read_write> is_big: array<u32>;
@group(0) @binding(13) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;
// The most pairs of a tile that is not big.
const MOST: u32 = 8192u;
const SLOTS: u32 = 1024u;
const NONE: u32 = 0xffffffffu;

// A table of bodies: the body of each slot, and its place in the list.
var<workgroup> body_in: array<atomic<u32>, 1024>;
var<workgroup> place_in: array<u32, 1024>;
var<workgroup> n_bodies: atomic<u32>;
var<workgroup> n_listed: atomic<u32>;
var<workgroup> has_failed: atomic<u32>;
var<workgroup> is_full: u32;

// The slot of a body, entered if it is not there and there is room.
fn slot_of(body: u32) -> u32 {
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
    return 0u;
}

fn enter(side: u32) {
    let body = side_of(side).body;
    // Past the limit a tile is big, whatever else it has.
    if activity[body] == MOVING && atomicLoad(&n_bodies) <= MOST_BODIES {
        slot_of(body);
    }
}

fn local_of(side: u32) -> u32 {
    let body = side_of(side).body;
    if activity[body] != MOVING {
        return 0xffffu;
    }
    return place_in[slot_of(body)];
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tile = (group.x + group.y * 65535u) * params[1] + params[0];
    if tile >= n_tiles[0] {
        return;
    }
    let first = tile_first[tile];
    let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
    for (var k = first + thread; k < end; k += THREADS) {
        pairs[k] = sorted[k];
    }
    if end - first > MOST || tile >= round_start[params[2]] {
        if thread == 0u {
            is_big[tile] = 1u;
        }
        return;
    }
    for (var s = thread; s < SLOTS; s += THREADS) {
        atomicStore(&body_in[s], NONE);
    }
    if thread == 0u {
        atomicStore(&n_bodies, 0u);
        atomicStore(&n_listed, 0u);
        atomicStore(&has_failed, 0u);
    }
    workgroupBarrier();
    for (var k = first + thread; k < end; k += THREADS) {
        enter(sorted[k].x);
        enter(sorted[k].y);
    }
    workgroupBarrier();
    if thread == 0u {
        let most = select(params[3], MOST_BODIES, tile < round_start[1]);
        is_full = select(0u, 1u, atomicLoad(&n_bodies) > most || atomicLoad(&has_failed) == 1u);
        is_big[tile] = is_full;
        tile_size[tile] = vec2(atomicLoad(&n_bodies), 0u);
    }
    if workgroupUniformLoad(&is_full) == 1u {
        return;
    }
    for (var s = thread; s < SLOTS; s += THREADS) {
        let body = atomicLoad(&body_in[s]);
        if body != NONE {
            let place = atomicAdd(&n_listed, 1u);
            place_in[s] = place;
            tile_body[2u * first + place] = body;
        }
    }
    workgroupBarrier();
    for (var k = first + thread; k < end; k += THREADS) {
        local[k] = local_of(sorted[k].x) | (local_of(sorted[k].y) << 16u);
    }
}
