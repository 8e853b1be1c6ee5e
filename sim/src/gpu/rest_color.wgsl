// Colour the pairs of big tiles, one tile after the other, by one workgroup: as in `tile_color`, but with claims in memory, and a colour
// for each round, of which there may be any number. The pairs are listed by their colours, so that a visit of one does not look at all.
// in    pairs       [n_pairs]
// in    sphere      [n_spheres]
// in    fixture     [n_fixtures]
// in    activity    [n_bodies]
// in    tile_first  [n_tiles]    first pair of each tile
// in    counts      [3]          n_tiles, n_pairs, and whether there is anything to do
// in    big         [n_big]      the big tiles
// in    n_big       [1]
// inout claim       [n_bodies]   all ones in and out
// out   color       [n_pairs]
// out   order       [n_pairs]    pairs of each big tile by their colours, from its first pair on; those without one last
// out   ends        [2 n_pairs]  ends of its colours in this list, from twice its first pair on
// out   tile_size   [n_tiles]    number of pairs without a colour, where a body has very many; number of colours
#import side

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> activity: array<u32>;
@group(0) @binding(4) var<storage, read> tile_first: array<u32>;
@group(0) @binding(5) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(6) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(7) var<storage, read> n_colored: array<u32>;
@group(0) @binding(8) var<storage, read> big: array<u32>;
@group(0) @binding(9) var<storage, read> n_big: array<u32>;
@group(0) @binding(10) var<storage, read_write> claim: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read_write> color: array<u32>;
@group(0) @binding(12) var<storage, read_write> order: array<u32>;
@group(0) @binding(13) var<storage, read_write> ends: array<u32>;
@group(0) @binding(14) var<storage, read_write> tile_size: array<vec2<u32>>;

const THREADS: u32 = 256u;
const NONE: u32 = 0xffffffffu;
// The most rounds: a loop of a kernel stays below 65,535. Pairs that are left are visited one after the other.
const MOST: u32 = 65000u;

var<workgroup> n_left: atomic<u32>;
var<workgroup> left: u32;
// Pairs that each thread colours in a round, and those of sixteen threads.
var<workgroup> numbers: array<u32, 256>;
var<workgroup> sums: array<u32, 16>;

// The numbers of the threads before one, and of all. All threads call it.
fn before(thread: u32, number: u32) -> vec2<u32> {
    workgroupBarrier();
    numbers[thread] = number;
    workgroupBarrier();
    if thread < 16u {
        var sum = 0u;
        for (var i = 0u; i < 16u; i++) {
            sum += numbers[16u * thread + i];
        }
        sums[thread] = sum;
    }
    workgroupBarrier();
    var n = vec2(0u);
    for (var i = 0u; i < 16u; i++) {
        n += vec2(select(0u, sums[i], i < thread / 16u), sums[i]);
    }
    for (var i = thread / 16u * 16u; i < thread; i++) {
        n.x += numbers[i];
    }
    return n;
}

// A number drawn from the place of a pair, another for each.
fn drawn(k: u32) -> u32 {
    var h = k * 0x9e3779b1u;
    h ^= h >> 15u;
    return h * 0x2c1b3c6du;
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let n_tiles_to_do = select(0u, n_big[0], n_colored[0] != 0u);
    for (var t = 0u; t < n_tiles_to_do; t++) {
        let tile = big[t];
        let first = tile_first[tile];
        let end = select(n_pairs[0], tile_first[min(tile + 1u, arrayLength(&tile_first) - 1u)], tile + 1u < n_tiles[0]);
        for (var k = first + thread; k < end; k += THREADS) {
            color[k] = NONE;
        }
        workgroupBarrier();
        if thread == 0u {
            left = 1u;
        }
        var n_rounds = 0u;
        var n_listed = 0u;
        for (var round = 0u; round < MOST; round++) {
            workgroupBarrier();
            if workgroupUniformLoad(&left) == 0u {
                break;
            }
            n_rounds++;
            if thread == 0u {
                atomicStore(&n_left, 0u);
            }
            for (var k = first + thread; k < end; k += THREADS) {
                if color[k] == NONE {
                    enter(pairs[k].x, drawn(k));
                    enter(pairs[k].y, drawn(k));
                }
            }
            storageBarrier();
            workgroupBarrier();
            var n_mine = 0u;
            for (var k = first + thread; k < end; k += THREADS) {
                if color[k] == NONE {
                    if is_first(pairs[k].x, drawn(k)) && is_first(pairs[k].y, drawn(k)) {
                        color[k] = round;
                        n_mine++;
                    } else {
                        atomicAdd(&n_left, 1u);
                    }
                }
            }
            storageBarrier();
            let n_before = before(thread, n_mine);
            var to = first + n_listed + n_before.x;
            n_listed += n_before.y;
            for (var k = first + thread; k < end; k += THREADS) {
                if color[k] == round {
                    order[to] = k;
                    to++;
                }
                if color[k] == NONE || color[k] == round {
                    leave(pairs[k].x);
                    leave(pairs[k].y);
                }
            }
            storageBarrier();
            workgroupBarrier();
            if thread == 0u {
                left = atomicLoad(&n_left);
                ends[2u * first + round] = n_listed;
            }
        }
        if thread == 0u {
            for (var k = first; k < select(first, end, left > 0u); k++) {
                if color[k] == NONE {
                    order[first + n_listed] = k;
                    n_listed++;
                }
            }
            tile_size[tile] = vec2(left, n_rounds);
        }
    }
}

fn enter(side: u32, number: u32) {
    let body = side_of(side).body;
    if activity[body] == MOVING {
        atomicMin(&claim[body], number);
    }
}

fn is_first(side: u32, number: u32) -> bool {
    let body = side_of(side).body;
    return activity[body] != MOVING || atomicLoad(&claim[body]) == number;
}

fn leave(side: u32) {
    let body = side_of(side).body;
    if activity[body] == MOVING {
        atomicStore(&claim[body], NONE);
    }
}
