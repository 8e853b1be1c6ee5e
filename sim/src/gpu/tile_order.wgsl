// Order the visits to the pairs of each tile, a workgroup for each: colour after colour, those of a colour in the order of the pairs. All are ordered
// where they are found, or in each step those that touch.
// in    place       [n_pairs + 1] number of contacts of the pairs before each pair, where those that touch are ordered
// in    local       [n_pairs]     places of the two bodies in the tile's list, 16 bits each; all ones for one that is held
// in    tile_first  [n_tiles]     first pair of each tile
// in    tile_size   [n_tiles]     number of bodies
// in    is_big      [n_tiles]
// in    round_start [10]          first tile of each round
// in    counts      [2]           n_tiles, n_pairs
// in    due         [1]           not zero if there is anything to do
// in    pairs       [n_pairs]
// in    sphere      [n_spheres]
// in    fixture     [n_fixtures]
// in    color       [n_pairs]     of `tile_color`
// out   tiles       [n_tiles]     first pair, number of visits, place of the first body in the list, and numbers of bodies (16 bits) and of colours
//                                 (16 bits); zeros for a big one
// out   order       [n_pairs]     visits of each tile, from its first pair on: the pair, from the tile's first on (16 bits), and its colour, of those
//                                 that there are (16 bits); the places of A and B of its contacts (16 bits each)
// in    params      [4]           whether all pairs are ordered; the index of this dispatch and the number of dispatches; number of rounds
// Twin: cpu/solve/schedule.rs
#import side
#import tile_listed

@group(0) @binding(0) var<storage, read> place: array<u32>;
@group(0) @binding(1) var<storage, read> local: array<u32>;
@group(0) @binding(2) var<storage, read> tile_first: array<u32>;
@group(0) @binding(3) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> is_big: array<u32>;
@group(0) @binding(5) var<storage, read> round_start: array<u32>;
@group(0) @binding(6) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(7) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(8) var<storage, read> due: array<u32>;
@group(0) @binding(9) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(11) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(12) var<storage, read> color: array<u32>;
@group(0) @binding(13) var<storage, read_write> tiles: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read_write> order: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read> params: array<u32>;

// Words with a bit for each pair that is listed.
const WORDS: u32 = 64u;

// A bit for each of `listed` that has a colour: `WORDS` words of each colour.
var<workgroup> has_color: array<atomic<u32>, 2112>;
// Number of visits of each colour, then before each; its index among the colours that there are.
var<workgroup> color_first: array<u32, 33>;
var<workgroup> color_index: array<u32, 33>;

// The places of the bodies of a pair, that of the lower id first, as its contacts have them.
fn places_of(pair: u32) -> u32 {
    let is_swapped = side_of(pairs[pair].x).body > side_of(pairs[pair].y).body;
    return select(local[pair], (local[pair] >> 16u) | (local[pair] << 16u), is_swapped);
}

// Number of bits of a colour before one.
fn n_of_color_before(c: u32, at: u32) -> u32 {
    var n = 0u;
    for (var word = 0u; word < at / 32u; word++) {
        n += countOneBits(atomicLoad(&has_color[c * WORDS + word]));
    }
    if at % 32u == 0u {
        return n;
    }
    return n + countOneBits(atomicLoad(&has_color[c * WORDS + at / 32u]) & ((1u << (at % 32u)) - 1u));
}

// Visits one after the other, where there are very many: by one thread.
fn list_all(first: u32, end: u32) {
    var n = 0u;
    for (var k = first; k < end; k++) {
        if is_listed(k) {
            order[first + n] = vec2((k - first) | (n << 16u), places_of(k));
            n++;
        }
    }
}

fn is_listed(pair: u32) -> bool {
    return params[0] == 1u || place[pair + 1u] > place[pair];
}

fn order_tile(tile: u32, thread: u32) {
    let first = tile_first[tile];
    let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
    let n_bodies = tile_size[tile].x;
    let n = list_pairs(first, end, thread);
    if n > MOST {
        if thread == 0u {
            list_all(first, end);
            tiles[tile] = vec4(first, n, 2u * first, n_bodies | (n << 16u));
        }
        return;
    }
    let words = (n + 31u) / 32u;
    for (var c = thread / WORDS; c <= MOST_COLORS; c += THREADS / WORDS) {
        if thread % WORDS < words {
            atomicStore(&has_color[c * WORDS + thread % WORDS], 0u);
        }
    }
    workgroupBarrier();
    for (var at = thread; at < n; at += THREADS) {
        atomicOr(&has_color[color[first + listed[at]] * WORDS + at / 32u], 1u << (at % 32u));
    }
    workgroupBarrier();
    if thread <= MOST_COLORS {
        color_first[thread] = n_of_color_before(thread, 32u * words);
    }
    workgroupBarrier();
    if thread == 0u {
        var before = 0u;
        var n_colors = 0u;
        for (var c = 0u; c <= MOST_COLORS; c++) {
            let own_number = color_first[c];
            color_first[c] = before;
            color_index[c] = n_colors;
            before += own_number;
            n_colors += select(min(own_number, 1u), own_number, c == MOST_COLORS);
        }
        tiles[tile] = vec4(first, n, 2u * first, n_bodies | (n_colors << 16u));
    }
    workgroupBarrier();
    for (var at = thread; at < n; at += THREADS) {
        let k = listed[at];
        let own = color[first + k];
        let rank = n_of_color_before(own, at);
        let index = color_index[own] + select(0u, rank, own == MOST_COLORS);
        order[first + color_first[own] + rank] = vec2(k | (index << 16u), places_of(first + k));
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
            order_tile(tile, thread);
        } else if thread == 0u {
            tiles[tile] = vec4(0u);
        }
    }
}
