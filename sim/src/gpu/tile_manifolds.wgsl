// Gauss–Seidel over the tiles of a round of shapes of any kind, a workgroup for each: the velocities of the tile's bodies are loaded into the
// memory of the workgroup, its pairs are visited colour by colour several times, each with its contacts one after the other, and the
// velocities are written back once. The tiles of a round share no moving body.
// in    rows         [n_contacts]
// in    visits       [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    order        [n_contacts]  visits of each tile, from its first contact on: the pair, from the tile's first on, and the end of the
//                                  visits of its colour; the places of A and B in the tile's list
// in    tile_first   [n_tiles]     first pair of each tile
// in    tile_body    [2 n_pairs]   bodies of each tile, from twice its first pair on
// in    tile_size    [n_tiles]     number of bodies, and of visits
// in    is_big       [n_tiles]
// in    round_start  [10]          first tile of each round
// in    counts       [2]           n_tiles, n_pairs
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// out   moved        [n_tiles]     residual terms of the first sweep squared, m²/s²
// out   terms        [n_contacts]  the same of the pair that begins with a contact
// in    mass         [n_bodies]    1/kg, and principal, 1/(kg m²)
// in    orientation  [n_bodies]    of the principal frames
// inout roll         [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row     [n_contacts]
// in    scalars      [1]
// in    params       [6]           round, sweeps, whether Coulomb's law is exact, as bits ω, and the index of this dispatch and the number of
//                                  dispatches of a round
// Twin: cpu/solve/sweeps.rs
#import sphere
#import manifold
#import scalars
#import tile_bodies

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> visits: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> tile_first: array<u32>;
@group(0) @binding(5) var<storage, read> tile_body: array<u32>;
@group(0) @binding(6) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> is_big: array<u32>;
@group(0) @binding(8) var<storage, read> round_start: array<u32>;
@group(0) @binding(9) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(10) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(11) var<storage, read_write> motion: array<Body>;
@group(0) @binding(12) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> moved: array<f32>;
@group(0) @binding(14) var<storage, read_write> terms: array<f32>;
@group(0) @binding(15) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(19) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(20) var<storage, read> params: array<u32>;

// Visit the contacts of a pair of a tile, whose bodies have these places. In the first sweep their residual terms squared are left.
fn visit_pair(pair: u32, places: u32, is_exact: bool, omega: f32, is_first: bool) {
    let first = place[pair];
    let end = place[pair + 1u];
    let bodies = rows[first].bodies;
    let at = vec2(places & 0xffffu, places >> 16u);
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
    if is_first {
        terms[first] = term;
    }
}

fn sweep_tile(tile: u32, thread: u32) {
    let first = tile_first[tile];
    let base = place[first];
    let size = tile_size[tile];
    let n = size.y;
    workgroupBarrier();
    for (var i = thread; i < size.x; i += THREADS) {
        let body = motion[tile_body[2u * first + i]];
        linear[i] = vec4(body.v, body.inv_mass);
        angular[i] = vec4(body.w, 0.0);
    }
    let is_exact = params[2] == 1u;
    let omega = bitcast<f32>(params[3]);
    for (var sweep = 0u; sweep < params[1]; sweep++) {
        var at = 0u;
        while at < n {
            let end = order[base + at].x >> 16u;
            workgroupBarrier();
            for (var i = at + thread; i < end; i += THREADS) {
                let visit = order[base + i];
                visit_pair(first + (visit.x & 0xffffu), visit.y, is_exact, omega, sweep == 0u);
            }
            at = end;
        }
    }
    storageBarrier();
    workgroupBarrier();
    for (var i = thread; i < size.x; i += THREADS) {
        let body = tile_body[2u * first + i];
        motion[body] = Body(linear[i].xyz, linear[i].w, angular[i].xyz, motion[body].inv_inertia);
    }
    // In the order of the pairs, whatever that of the visits has been.
    var end = n_pairs[0];
    if tile + 1u < n_tiles[0] {
        end = tile_first[tile + 1u];
    }
    var term = 0.0;
    for (var k = first + thread; k < end; k += THREADS) {
        if place[k + 1u] > place[k] {
            term += terms[place[k]];
        }
    }
    let total = tile_total(thread, term);
    if thread == 0u {
        moved[tile] = total;
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
