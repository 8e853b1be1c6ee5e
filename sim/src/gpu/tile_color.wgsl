// Colour the pairs of each tile, a workgroup for each: pairs of one colour have no moving body in common. All are coloured where they are found, or
// in each step those that touch. Colours do not depend on the order in which threads run: in each round a pair that comes first among those of
// both of its bodies, by a number drawn from its place, takes the least colour that these have free.
// in    place       [n_pairs + 1] number of contacts of the pairs before each pair, where those that touch are coloured
// in    local       [n_pairs]     places of the two bodies in the tile's list, 16 bits each; all ones for one that is held
// in    tile_first  [n_tiles]     first pair of each tile
// in    tile_size   [n_tiles]     number of bodies
// in    is_big      [n_tiles]
// in    round_start [10]          first tile of each round
// in    counts      [2]           n_tiles, n_pairs
// in    due         [1]           not zero if there is anything to do
// out   color       [n_pairs]     32 for a pair that no colour was free for
// in    params      [4]           whether all pairs are coloured; the index of this dispatch and the number of dispatches; number of rounds
// Twin: cpu/solve/schedule.rs
#import sphere
#import tile_listed
#import tile_most

@group(0) @binding(0) var<storage, read> place: array<u32>;
@group(0) @binding(1) var<storage, read> local: array<u32>;
@group(0) @binding(2) var<storage, read> tile_first: array<u32>;
@group(0) @binding(3) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> is_big: array<u32>;
@group(0) @binding(5) var<storage, read> round_start: array<u32>;
@group(0) @binding(6) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(7) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(8) var<storage, read> due: array<u32>;
@group(0) @binding(9) var<storage, read_write> color: array<u32>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

const NONE: u32 = 0xffffffffu;
const NOWHERE: u32 = 0xffffu;

// Of each body: the pair that claims it, and the colours that it has.
var<workgroup> claim: array<atomic<u32>, MOST_BODIES>;
var<workgroup> taken: array<atomic<u32>, MOST_BODIES>;
var<workgroup> n_left: atomic<u32>;
var<workgroup> left: u32;

// A number drawn from the place of a pair, another for each.
fn drawn(k: u32) -> u32 {
    return (((k * 0x2c1b3c6du) >> 13u) << 13u) | k;
}

fn take(body: u32, bit: u32) {
    if body != NOWHERE {
        atomicOr(&taken[body], bit);
    }
}

fn is_listed(pair: u32) -> bool {
    return params[0] == 1u || place[pair + 1u] > place[pair];
}

fn color_tile(tile: u32, thread: u32) {
    let first = tile_first[tile];
    let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
    workgroupBarrier();
    for (var b = thread; b < min(tile_size[tile].x, MOST_BODIES); b += THREADS) {
        atomicStore(&claim[b], NONE);
        atomicStore(&taken[b], 0u);
    }
    let n = list_pairs(first, end, thread);
    if n > MOST {
        // Each is visited alone.
        for (var k = first + thread; k < end; k += THREADS) {
            color[k] = MOST_COLORS;
        }
        return;
    }
    let slots = (n + THREADS - 1u) / THREADS;
    var places: array<vec2<u32>, 8>;
    var own: array<u32, 8>;
    for (var i = 0u; i < slots; i++) {
        let at = i * THREADS + thread;
        own[i] = MOST_COLORS;
        if at < n {
            own[i] = NONE;
            let pair = local[first + listed[at]];
            places[i] = vec2(pair & 0xffffu, pair >> 16u);
        }
    }
    if thread == 0u {
        left = n;
    }
    // Each round colours one pair at least.
    for (var round = 0u; round <= MOST; round++) {
        if workgroupUniformLoad(&left) == 0u {
            break;
        }
        if thread == 0u {
            atomicStore(&n_left, 0u);
        }
        for (var i = 0u; i < slots; i++) {
            if own[i] == NONE {
                let number = drawn(listed[i * THREADS + thread]);
                if places[i].x != NOWHERE {
                    atomicMin(&claim[places[i].x], number);
                }
                if places[i].y != NOWHERE {
                    atomicMin(&claim[places[i].y], number);
                }
            }
        }
        workgroupBarrier();
        // Bits of the pairs that are coloured in this round.
        var mine = 0u;
        for (var i = 0u; i < slots; i++) {
            if own[i] == NONE {
                let number = drawn(listed[i * THREADS + thread]);
                var is_first = true;
                var used = 0u;
                if places[i].x != NOWHERE {
                    is_first = atomicLoad(&claim[places[i].x]) == number;
                    used = atomicLoad(&taken[places[i].x]);
                }
                if places[i].y != NOWHERE {
                    is_first = is_first && atomicLoad(&claim[places[i].y]) == number;
                    used |= atomicLoad(&taken[places[i].y]);
                }
                if is_first {
                    mine |= 1u << i;
                    own[i] = select(firstTrailingBit(~used), MOST_COLORS, used == NONE);
                    color[first + listed[i * THREADS + thread]] = own[i];
                }
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < slots; i++) {
            let is_mine = (mine >> i & 1u) == 1u;
            if is_mine && own[i] < MOST_COLORS {
                take(places[i].x, 1u << own[i]);
                take(places[i].y, 1u << own[i]);
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
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let end = select(0u, round_start[params[3]], due[0] != 0u);
    for (var tile = group.x * params[2] + params[1]; tile < end; tile += groups.x * params[2]) {
        if is_big[tile] == 0u {
            color_tile(tile, thread);
        }
    }
}
