// Gauss–Seidel over the tiles of a round of shapes of any kind, a workgroup for each: the velocities of the tile's bodies are loaded into the
// memory of the workgroup, its pairs are visited colour by colour several times, each with its contacts one after the other, and the
// velocities are written back once. The tiles of a round share no moving body.
// in    rows         [n_contacts]
// in    visits       [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    order        [n_pairs]     visits of each tile, from its first pair on: the pair, from the tile's first on, and its colour; the places of A
//                                  and B in the tile's list
// in    tiles        [n_tiles]     first pair, number of visits, place of the first body in the list, which is twice the first pair, and numbers of
//                                  bodies and of colours
// in    tile_body    [2 n_pairs]   bodies of each tile
// in    round_start  [10]          first tile of each round
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// inout moved        [n_tiles]     residual terms of the first sweep squared, m²/s²; negative where the tile is settled
// in    mass         [n_bodies]    1/kg, and principal, 1/(kg m²)
// in    orientation  [n_bodies]    of the principal frames
// inout roll         [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row     [n_contacts]
// in    scalars      [1]
// in    params       [8]           round, the index of this dispatch and the number of dispatches of a round, sweeps, as bits ω, whether
//                                  Coulomb's law is exact, and as bits the squares of the residual of slow bodies and of their speed, m²/s²;
//                                  zero where sweeps do not go on for them
// Twin: cpu/solve/sweeps.rs
#import sphere
#import manifold
#import scalars
#import tile_most
#import tile_bodies
#import settling

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> visits: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> tile_body: array<u32>;
@group(0) @binding(6) var<storage, read> round_start: array<u32>;
@group(0) @binding(7) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(8) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> moved: array<f32>;
@group(0) @binding(10) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(15) var<storage, read> params: array<u32>;

const THREADS: u32 = 128u;
const ROOM: u32 = MOST_BODIES;
// The place of a body that is held.
const NOWHERE: u32 = 0xffffu;
// A visit of no colour.
const NONE: u32 = 0xffffffffu;

// A pair of a tile: its first contact and their end, the places of its bodies, and their inertia.
struct Pair {
    first: u32,
    end: u32,
    at: vec2<u32>,
    a: Tensor,
    b: Tensor,
}

// The pair of a row of `order`, of the tile whose pairs begin at `first`.
fn pair_of(visit: vec2<u32>, first: u32) -> Pair {
    var own: Pair;
    let pair = first + (visit.x & 0xffffu);
    own.first = place[pair];
    own.end = place[pair + 1u];
    own.at = vec2(visit.y & 0xffffu, visit.y >> 16u);
    let bodies = rows[own.first].bodies;
    own.a = tensor_of(bodies.x);
    own.b = tensor_of(bodies.y);
    return own;
}

// Visit the contacts of a pair. Returns their residual terms squared.
fn visit_pair(own: Pair, is_exact: bool, omega: f32) -> f32 {
    let at = own.at;
    let a_moves = at.x != NOWHERE;
    let b_moves = at.y != NOWHERE;
    var two: Two;
    if a_moves {
        two.va = linear[at.x].xyz;
        two.mass_a = linear[at.x].w;
        two.wa = angular[at.x].xyz;
        two.a = own.a;
    }
    if b_moves {
        two.vb = linear[at.y].xyz;
        two.mass_b = linear[at.y].w;
        two.wb = angular[at.y].xyz;
        two.b = own.b;
    }
    var term = 0.0;
    for (var k = own.first; k < own.end; k++) {
        term += visit(k, &two, is_exact, omega);
    }
    if a_moves {
        linear[at.x] = vec4(two.va, two.mass_a);
        angular[at.x] = vec4(two.wa, angular[at.x].w);
    }
    if b_moves {
        linear[at.y] = vec4(two.vb, two.mass_b);
        angular[at.y] = vec4(two.wb, angular[at.y].w);
    }
    return term;
}

// Beyond the iterations of the settings tiles that are not settled are swept alone.
fn is_due(tile: u32) -> bool {
    let is_beyond = scalars[0].trials >= scalars[0].limit && params[6] > 0u;
    return !is_beyond || moved[tile] > 0.0;
}

fn sweep_tile(tile: u32, thread: u32) {
    let first = tiles[tile].x;
    let n = tiles[tile].y;
    let first_body = tiles[tile].z;
    let n_bodies = tiles[tile].w & 0xffffu;
    let n_colors = tiles[tile].w >> 16u;
    workgroupBarrier();
    for (var i = thread; i < n_bodies; i += THREADS) {
        let body = motion[tile_body[first_body + i]];
        linear[i] = body.linear;
        angular[i] = body.angular;
    }
    // A thread's first visit is looked up once.
    var own_visit = vec2(NONE);
    var own: Pair;
    if thread < n {
        own_visit = order[first + thread];
        own = pair_of(own_visit, first);
    }
    let is_exact = params[5] == 1u;
    let omega = bitcast<f32>(params[4]);
    var term = 0.0;
    for (var sweep = 0u; sweep < params[3]; sweep++) {
        for (var color = 0u; color < n_colors; color++) {
            workgroupBarrier();
            if own_visit.x >> 16u == color {
                let of_pair = visit_pair(own, is_exact, omega);
                term += select(0.0, of_pair, sweep == 0u);
            }
            for (var i = THREADS + thread; i < n; i += THREADS) {
                let visit = order[first + i];
                if visit.x >> 16u == color {
                    let of_pair = visit_pair(pair_of(visit, first), is_exact, omega);
                    term += select(0.0, of_pair, sweep == 0u);
                }
            }
        }
    }
    workgroupBarrier();
    let speed2 = bitcast<f32>(params[7]);
    var n_fast = 0.0;
    for (var i = thread; i < n_bodies; i += THREADS) {
        motion[tile_body[first_body + i]] = BodyRow(linear[i], angular[i]);
        n_fast += select(0.0, 1.0, dot(linear[i].xyz, linear[i].xyz) > speed2);
    }
    let total = tile_total(thread, term);
    if params[6] > 0u {
        workgroupBarrier();
        n_fast = tile_total(thread, n_fast);
    }
    if thread == 0u {
        moved[tile] = settled(total, n_fast, f32(n), bitcast<f32>(params[6]));
    }
}

@compute @workgroup_size(128)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    sweep_round(group.x, groups.x, thread);
}
