// Colour the pairs of each tile that touch in this step, a workgroup for each: pairs of one colour have no moving body in common. A visit is
// made to each, colour after colour. Colours do not depend on the order in which threads run: in each round a pair that comes first among
// those of both of its bodies, by a number drawn from its place, takes the least colour that these have free. The order of the visits of a colour
// does, and their results do not depend on it.
// in    place       [n_pairs + 1] number of contacts of the pairs before each pair
// in    local       [n_pairs]     places of the two bodies in the tile's list, 16 bits each; all ones for one that is held
// in    tile_first  [n_tiles]     first pair of each tile
// in    tile_body   [2 n_pairs]   bodies of each tile, from twice its first pair on
// in    is_big      [n_tiles]
// in    round_start [10]          first tile of each round
// in    counts      [2]           n_tiles, n_pairs
// in    rows        [n_contacts]
// inout tile_size   [n_tiles]     number of bodies in, and of visits out
// out   order       [n_contacts]  visits of each tile, from its first contact on: the pair, from the tile's first on (16 bits), and the end
//                                 of the visits of its colour (16 bits); the places of A and B of its contacts (16 bits each)
// in    params      [3]           whether it is the first contact of the pair, from the tile's first on, that stands for it; the index of this
//                                 dispatch and the number of dispatches
// Twin: cpu/solve/schedule.rs
#import sphere
#import solve_row

@group(0) @binding(0) var<storage, read> place: array<u32>;
@group(0) @binding(1) var<storage, read> local: array<u32>;
@group(0) @binding(2) var<storage, read> tile_first: array<u32>;
@group(0) @binding(3) var<storage, read> tile_body: array<u32>;
@group(0) @binding(4) var<storage, read> is_big: array<u32>;
@group(0) @binding(5) var<storage, read> round_start: array<u32>;
@group(0) @binding(6) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(7) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(8) var<storage, read> rows: array<Row>;
@group(0) @binding(9) var<storage, read_write> tile_size: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read_write> order: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;
// The most visits that are coloured, eight to a thread; of more, each is a colour of its own.
const MOST: u32 = 2048u;
const MOST_COLORS: u32 = 32u;
const NONE: u32 = 0xffffffffu;
const NOWHERE: u32 = 0xffffu;
// Beside a pair in `touching` that no colour was free for.
const LEFT: u32 = 0x10000u;

// Pairs that touch, from the tile's first on.
var<workgroup> touching: array<u32, 2048>;
// Of each body: the pair that claims it, and the colours that it has.
var<workgroup> claim: array<atomic<u32>, 480>;
var<workgroup> taken: array<atomic<u32>, 480>;
var<workgroup> n_touching: atomic<u32>;
var<workgroup> n_left: atomic<u32>;
var<workgroup> left: u32;
// Number of visits of each colour so far, and before each colour.
var<workgroup> n_of_color: array<atomic<u32>, 33>;
var<workgroup> color_first: array<u32, 33>;

// A number drawn from the place of a pair, another for each.
fn drawn(k: u32) -> u32 {
    return (((k * 0x2c1b3c6du) >> 13u) << 13u) | k;
}

// The bodies' places of the pair of an index, as its contacts have them: the pair has its moving shape first, a contact the body of the
// lower id.
fn places_of(pair: u32, of_tile: u32) -> u32 {
    let own = vec2(local[pair] & 0xffffu, local[pair] >> 16u);
    let x_moves = own.x != NOWHERE;
    let is_a = tile_body[of_tile + select(own.y, own.x, x_moves)] == rows[place[pair]].bodies.x;
    let ordered = select(own.yx, own, is_a == x_moves);
    return ordered.x | (ordered.y << 16u);
}

// What stands for a pair.
fn visited(first: u32, k: u32) -> u32 {
    return select(k, place[first + k] - place[first], params[0] == 1u);
}

// Visits one after the other, where there are very many: by one thread.
fn list_all(first: u32, end: u32) -> u32 {
    var n = 0u;
    for (var k = first; k < end; k++) {
        if place[k + 1u] > place[k] {
            order[place[first] + n] = vec2(visited(first, k - first) | ((n + 1u) << 16u), places_of(k, 2u * first));
            n++;
        }
    }
    return n;
}

fn color_tile(tile: u32, thread: u32) {
    let first = tile_first[tile];
    let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
    let base = place[first];
    let n_bodies = tile_size[tile].x;
    workgroupBarrier();
    for (var b = thread; b < min(n_bodies, 480u); b += THREADS) {
        atomicStore(&claim[b], NONE);
        atomicStore(&taken[b], 0u);
    }
    if thread < 33u {
        atomicStore(&n_of_color[thread], 0u);
    }
    if thread == 0u {
        atomicStore(&n_touching, 0u);
    }
    workgroupBarrier();
    for (var k = first + thread; k < end; k += THREADS) {
        if place[k + 1u] > place[k] {
            let at = atomicAdd(&n_touching, 1u);
            if at < MOST {
                touching[at] = k - first;
            }
        }
    }
    workgroupBarrier();
    if thread == 0u {
        left = atomicLoad(&n_touching);
    }
    let n = workgroupUniformLoad(&left);
    if n > MOST {
        if thread == 0u {
            tile_size[tile] = vec2(n_bodies, list_all(first, end));
        }
        return;
    }
    var places: array<vec2<u32>, 8>;
    var number: array<u32, 8>;
    var own: array<u32, 8>;
    for (var i = 0u; i < 8u; i++) {
        let at = i * THREADS + thread;
        own[i] = NONE - 1u;
        if at < n {
            own[i] = NONE;
            number[i] = drawn(touching[at]);
            let pair = local[first + touching[at]];
            places[i] = vec2(pair & 0xffffu, pair >> 16u);
        }
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
        for (var i = 0u; i < 8u; i++) {
            if own[i] == NONE {
                if places[i].x != NOWHERE {
                    atomicMin(&claim[places[i].x], number[i]);
                }
                if places[i].y != NOWHERE {
                    atomicMin(&claim[places[i].y], number[i]);
                }
            }
        }
        workgroupBarrier();
        // Bits of the pairs that are coloured in this round.
        var mine = 0u;
        for (var i = 0u; i < 8u; i++) {
            if own[i] == NONE {
                var is_first = true;
                var used = 0u;
                if places[i].x != NOWHERE {
                    is_first = atomicLoad(&claim[places[i].x]) == number[i];
                    used = atomicLoad(&taken[places[i].x]);
                }
                if places[i].y != NOWHERE {
                    is_first = is_first && atomicLoad(&claim[places[i].y]) == number[i];
                    used |= atomicLoad(&taken[places[i].y]);
                }
                if is_first {
                    mine |= 1u << i;
                    own[i] = select(firstTrailingBit(~used), MOST_COLORS, used == NONE);
                }
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < 8u; i++) {
            let is_mine = (mine >> i & 1u) == 1u;
            if is_mine {
                let bit = select(1u << (own[i] % 32u), 0u, own[i] == MOST_COLORS);
                if places[i].x != NOWHERE {
                    atomicOr(&taken[places[i].x], bit);
                }
                if places[i].y != NOWHERE {
                    atomicOr(&taken[places[i].y], bit);
                }
            }
            if is_mine || own[i] == NONE {
                if places[i].x != NOWHERE {
                    atomicStore(&claim[places[i].x], NONE);
                }
                if places[i].y != NOWHERE {
                    atomicStore(&claim[places[i].y], NONE);
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
    for (var i = 0u; i < 8u; i++) {
        let at = i * THREADS + thread;
        if at < n {
            atomicAdd(&n_of_color[own[i]], 1u);
            if own[i] == MOST_COLORS {
                touching[at] |= LEFT;
            }
        }
    }
    workgroupBarrier();
    if thread == 0u {
        var before = 0u;
        for (var c = 0u; c <= MOST_COLORS; c++) {
            color_first[c] = before;
            before += atomicLoad(&n_of_color[c]);
            atomicStore(&n_of_color[c], 0u);
        }
        tile_size[tile] = vec2(n_bodies, n);
    }
    workgroupBarrier();
    for (var i = 0u; i < 8u; i++) {
        let at = i * THREADS + thread;
        if at < n {
            let k = touching[at] & 0xffffu;
            var to = color_first[own[i]];
            var last = 0u;
            if own[i] < MOST_COLORS {
                last = color_first[own[i] + 1u];
                to += atomicAdd(&n_of_color[own[i]], 1u);
            } else {
                // Each that is left is visited alone, in the order of the pairs.
                for (var j = 0u; j < n; j++) {
                    to += u32(touching[j] >= LEFT && (touching[j] & 0xffffu) < k);
                }
                last = to + 1u;
            }
            order[base + to] = vec2(visited(first, k) | (last << 16u), places_of(first + k, 2u * first));
        }
    }
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var tile = group.x * params[2] + params[1]; tile < round_start[8]; tile += groups.x * params[2]) {
        if is_big[tile] == 0u {
            color_tile(tile, thread);
        }
    }
}
