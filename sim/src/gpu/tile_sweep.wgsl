// Gauss–Seidel over the tiles of a round, a workgroup for each: the tile's bodies are loaded into the memory of the workgroup, each thread
// takes up to four contacts, which are swept colour by colour several times, and all is written back once. The tiles of a round share no
// moving body.
// in    rows         [n_contacts]
// in    touching     [n_contacts]  the pair of each contact
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    color        [n_pairs]
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
// in    params       [6]           round, sweeps, whether Coulomb's law is exact, as bits ω, and the index of this dispatch and the number of
//                                dispatches of a round
// Twin: cpu/solve/sweeps.rs
#import sphere
#import visit

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> touching: array<u32>;
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
@group(0) @binding(15) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;
// The place of a body that is held.
const NOWHERE: u32 = 0x3ffu;
// The colour of no contact, and where a contact has its colour, behind ten bits for each of the places of its bodies.
const NO_COLOR: u32 = 0xfffu;
const COLOR: u32 = 20u;

// Velocities with reciprocal masses, angular velocities with reciprocal moments of inertia.
var<workgroup> linear: array<vec4<f32>, 480>;
var<workgroup> angular: array<vec4<f32>, 480>;

// A contact in the registers of a thread: of its row what a visit needs, 1/a and 1/b, its impulse, its colour and the places of its bodies.
struct Own {
    normal: vec3<f32>,
    offset: f32,
    reach: vec2<f32>,
    inverse: vec2<f32>,
    gamma: vec3<f32>,
    friction: f32,
    at: u32,
}

fn linear_of(at: u32) -> vec4<f32> {
    if at == NOWHERE {
        return vec4(0.0);
    }
    return linear[at];
}

fn angular_of(at: u32) -> vec4<f32> {
    if at == NOWHERE {
        return vec4(0.0);
    }
    return angular[at];
}

// The contact of an index; its colour is none where there is no such contact.
fn contact_at(k: u32, end: u32) -> Own {
    var own: Own;
    own.at = NO_COLOR << COLOR;
    if k < end {
        let pair = touching[k];
        let row = rows[k];
        own.normal = row.normal;
        own.offset = row.offset;
        own.reach = row.reach;
        own.friction = row.friction;
        own.gamma = gamma[k].xyz;
        // The pair has its sphere first, the contact the body of the lower id.
        let places = min(vec2(local[pair] & 0xffffu, local[pair] >> 16u), vec2(NOWHERE));
        let a_moves = places.x != NOWHERE;
        let is_a = tile_body[own_first + select(places.y, places.x, a_moves)] == row.bodies.x;
        let ordered = select(places.yx, places, is_a == a_moves);
        own.at = (color[pair] << COLOR) | (ordered.y << 10u) | ordered.x;
        let p = vec2(linear_of(ordered.x).w, angular_of(ordered.x).w);
        let q = vec2(linear_of(ordered.y).w, angular_of(ordered.y).w);
        own.inverse = inverse_of(row, vec2(p.x, q.x), vec2(p.y, q.y));
    }
    return own;
}

// Twice the first pair of the tile.
var<private> own_first: u32;

// Visit a contact. Returns its residual term squared.
fn visit(own: ptr<function, Own>) -> f32 {
    // The trace of N_ii, three times the reciprocal of η.
    let trace = 1.0 / (*own).inverse.x + 2.0 / (*own).inverse.y;
    var row: Row;
    row.normal = (*own).normal;
    row.offset = (*own).offset;
    row.reach = (*own).reach;
    row.friction = (*own).friction;
    let places = vec2((*own).at & NOWHERE, ((*own).at >> 10u) & NOWHERE);
    var va = linear_of(places.x);
    var vb = linear_of(places.y);
    var wa = angular_of(places.x);
    var wb = angular_of(places.y);
    let rolling = cross(row.normal, wa.xyz * row.reach.x + wb.xyz * row.reach.y);
    let gradient = vb.xyz - va.xyz + rolling + row.normal * row.offset;
    let z = visited(row, (*own).gamma, gradient, (*own).inverse, params[2] == 1u);
    let d = (z - (*own).gamma) * bitcast<f32>(params[3]);
    (*own).gamma += d;
    let spin = cross(row.normal, d);
    if places.x != NOWHERE {
        linear[places.x] = vec4(va.xyz - d * va.w, va.w);
        angular[places.x] = vec4(wa.xyz - spin * (row.reach.x * wa.w), wa.w);
    }
    if places.y != NOWHERE {
        linear[places.y] = vec4(vb.xyz + d * vb.w, vb.w);
        angular[places.y] = vec4(wb.xyz - spin * (row.reach.y * wb.w), wb.w);
    }
    return dot(d, d) * trace * trace / 9.0;
}

@compute @workgroup_size(256)
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
    let first_pair = tile_first[tile];
    own_first = 2u * first_pair;
    var end_pair = n_pairs[0];
    if tile + 1u < n_tiles[0] {
        end_pair = tile_first[tile + 1u];
    }
    let first = place[first_pair];
    let end = place[end_pair];
    let size = tile_size[tile];
    for (var i = thread; i < size.x; i += THREADS) {
        let body = motion[tile_body[own_first + i]];
        linear[i] = vec4(body.v, body.inv_mass);
        angular[i] = vec4(body.w, body.inv_inertia);
    }
    workgroupBarrier();
    var own0 = contact_at(first + thread, end);
    var own1 = contact_at(first + thread + THREADS, end);
    var own2 = contact_at(first + thread + 2u * THREADS, end);
    var own3 = contact_at(first + thread + 3u * THREADS, end);
    var term = 0.0;
    let n_parts = (end - first + THREADS - 1u) / THREADS;
    for (var sweep = 0u; sweep < params[1]; sweep++) {
        for (var c = 0u; c < size.y; c++) {
            workgroupBarrier();
            let is_first = sweep == 0u;
            if own0.at >> COLOR == c {
                term += select(0.0, visit(&own0), is_first);
            }
            if n_parts > 1u {
                if own1.at >> COLOR == c {
                    term += select(0.0, visit(&own1), is_first);
                }
                if own2.at >> COLOR == c {
                    term += select(0.0, visit(&own2), is_first);
                }
                if own3.at >> COLOR == c {
                    term += select(0.0, visit(&own3), is_first);
                }
            }
        }
    }
    let total = term_total(thread, term);
    if thread == 0u {
        moved[tile] = total;
    }
    if first + thread < end {
        gamma[first + thread] = vec4(own0.gamma, 0.0);
    }
    if first + thread + THREADS < end {
        gamma[first + thread + THREADS] = vec4(own1.gamma, 0.0);
    }
    if first + thread + 2u * THREADS < end {
        gamma[first + thread + 2u * THREADS] = vec4(own2.gamma, 0.0);
    }
    if first + thread + 3u * THREADS < end {
        gamma[first + thread + 3u * THREADS] = vec4(own3.gamma, 0.0);
    }
    for (var i = thread; i < size.x; i += THREADS) {
        let body = tile_body[own_first + i];
        motion[body] = Body(linear[i].xyz, linear[i].w, angular[i].xyz, angular[i].w);
    }
}
