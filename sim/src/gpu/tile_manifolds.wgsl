// Gauss–Seidel over the tiles of a round of shapes of any kind, a workgroup for each: the velocities of the tile's bodies are loaded into the
// memory of the workgroup, its pairs are visited colour by colour several times, each with its contacts one after the other, and the
// velocities are written back once. The tiles of a round share no moving body.
// in    rows         [n_contacts]
// in    visits       [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    color        [n_pairs]     the pairs of a tile lie in the order of their colours
// in    local        [n_pairs]     places of the bodies in the tile's list
// in    tile_first   [n_tiles]     first pair of each tile
// in    tile_body    [2 n_pairs]   bodies of each tile, from twice its first pair on
// in    tile_size    [n_tiles]     number of bodies, and of colours
// in    is_big       [n_tiles]
// in    round_start  [10]          first tile of each round
// in    counts       [2]           n_tiles, n_pairs
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// out   moved        [n_tiles]     residual terms of the first sweep squared, m²/s²
// in    mass         [n_bodies]    1/kg, and principal, 1/(kg m²)
// in    orientation  [n_bodies]    of the principal frames
// inout roll         [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row     [n_contacts]
// in    params       [6]           round, sweeps, whether Coulomb's law is exact, as bits ω, and the index of this dispatch and the number of
//                                dispatches of a round
// Twin: cpu/solve/sweeps.rs
#import sphere
#import manifold

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> visits: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> color: array<u32>;
@group(0) @binding(4) var<storage, read> local: array<u32>;
@group(0) @binding(5) var<storage, read> tile_first: array<u32>;
@group(0) @binding(6) var<storage, read> tile_body: array<u32>;
@group(0) @binding(7) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read> is_big: array<u32>;
@group(0) @binding(9) var<storage, read> round_start: array<u32>;
@group(0) @binding(10) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(11) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(12) var<storage, read_write> motion: array<Body>;
@group(0) @binding(13) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read_write> moved: array<f32>;
@group(0) @binding(15) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(19) var<storage, read> params: array<u32>;

const THREADS: u32 = 128u;
const NOWHERE: u32 = 0xffffu;

// Velocities with reciprocal masses, and angular velocities.
var<workgroup> linear: array<vec4<f32>, 256>;
var<workgroup> angular: array<vec4<f32>, 256>;
// First pair of each colour, from the tile's first on, and the end.
var<workgroup> color_first: array<u32, 33>;
var<workgroup> terms: array<f32, 128>;

// Visit the contacts of a pair of a tile. Returns their residual terms squared.
fn visit_pair(pair: u32, of_tile: u32, is_exact: bool, omega: f32) -> f32 {
    let first = place[pair];
    let end = place[pair + 1u];
    if first == end {
        return 0.0;
    }
    let bodies = rows[first].bodies;
    // The pair has its moving shape first, the contact the body of the lower id.
    let places = vec2(local[pair] & 0xffffu, local[pair] >> 16u);
    let x_moves = places.x != NOWHERE;
    let is_a = tile_body[of_tile + select(places.y, places.x, x_moves)] == bodies.x;
    let at = select(places.yx, places, is_a == x_moves);
    let a_moves = at.x != NOWHERE;
    let b_moves = at.y != NOWHERE;
    var two: Two;
    if a_moves {
        two.va = linear[at.x].xyz;
        two.mass_a = linear[at.x].w;
        two.wa = angular[at.x].xyz;
        two.a = tensor_of(bodies.x);
    }
    if b_moves {
        two.vb = linear[at.y].xyz;
        two.mass_b = linear[at.y].w;
        two.wb = angular[at.y].xyz;
        two.b = tensor_of(bodies.y);
    }
    var term = 0.0;
    for (var k = first; k < end; k++) {
        term += visit(k, &two, is_exact, omega);
    }
    if a_moves {
        linear[at.x] = vec4(two.va, two.mass_a);
        angular[at.x] = vec4(two.wa, 0.0);
    }
    if b_moves {
        linear[at.y] = vec4(two.vb, two.mass_b);
        angular[at.y] = vec4(two.wb, 0.0);
    }
    return term;
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tile = round_start[params[0]] + (group.x + group.y * 65535u) * params[5] + params[4];
    if tile >= round_start[params[0] + 1u] {
        return;
    }
    if is_big[tile] == 1u {
        if thread == 0u {
            moved[tile] = 0.0;
        }
        return;
    }
    let first = tile_first[tile];
    var end = n_pairs[0];
    if tile + 1u < n_tiles[0] {
        end = tile_first[tile + 1u];
    }
    let size = tile_size[tile];
    for (var i = thread; i < size.x; i += THREADS) {
        let body = motion[tile_body[2u * first + i]];
        linear[i] = vec4(body.v, body.inv_mass);
        angular[i] = vec4(body.w, 0.0);
    }
    for (var k = first + thread; k < end; k += THREADS) {
        if k == first || color[max(k, 1u) - 1u] != color[k] {
            color_first[color[k]] = k;
        }
    }
    if thread == 0u {
        color_first[size.y] = end;
    }
    let is_exact = params[2] == 1u;
    let omega = bitcast<f32>(params[3]);
    var term = 0.0;
    for (var sweep = 0u; sweep < params[1]; sweep++) {
        for (var c = 0u; c < size.y; c++) {
            workgroupBarrier();
            for (var k = color_first[c] + thread; k < color_first[c + 1u]; k += THREADS) {
                term += select(0.0, visit_pair(k, 2u * first, is_exact, omega), sweep == 0u);
            }
        }
    }
    workgroupBarrier();
    terms[thread] = term;
    for (var step = 1u; step < THREADS; step <<= 1u) {
        workgroupBarrier();
        if thread % (2u * step) == 0u {
            terms[thread] += terms[thread + step];
        }
    }
    if thread == 0u {
        moved[tile] = terms[0];
    }
    for (var i = thread; i < size.x; i += THREADS) {
        let body = tile_body[2u * first + i];
        motion[body] = Body(linear[i].xyz, linear[i].w, angular[i].xyz, motion[body].inv_inertia);
    }
}
