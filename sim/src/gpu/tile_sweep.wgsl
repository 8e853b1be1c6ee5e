// Gauss–Seidel over the tiles of a round, a workgroup for each: the tile's bodies are loaded into the memory of the workgroup, each thread
// takes up to four contacts, which are swept colour by colour several times, and all is written back once; contacts beyond those stay in
// memory. The tiles of a round share no moving body.
// in    rows         [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    order        [n_contacts]  visits of each tile, from its first contact on: the contact, from the tile's first on, and the end of the
//                                  visits of its colour; the places of A and B in the tile's list
// in    tile_first   [n_tiles]     first pair of each tile
// in    tile_body    [2 n_pairs]   bodies of each tile, from twice its first pair on
// in    tile_size    [n_tiles]     number of bodies, and of visits
// in    is_big       [n_tiles]
// in    round_start  [10]          first tile of each round
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// out   moved        [n_tiles]     residual terms of the first sweep squared, m²/s²
// out   terms        [n_contacts]  the same of each contact
// in    scalars      [1]
// in    params       [6]           round, sweeps, whether Coulomb's law is exact, as bits ω, and the index of this dispatch and the number of
//                                  dispatches of a round
// Twin: cpu/solve/sweeps.rs
#import sphere
#import visit
#import scalars
#import tile_bodies

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> place: array<u32>;
@group(0) @binding(2) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> tile_first: array<u32>;
@group(0) @binding(4) var<storage, read> tile_body: array<u32>;
@group(0) @binding(5) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> is_big: array<u32>;
@group(0) @binding(7) var<storage, read> round_start: array<u32>;
@group(0) @binding(8) var<storage, read_write> motion: array<Body>;
@group(0) @binding(9) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> moved: array<f32>;
@group(0) @binding(11) var<storage, read_write> terms: array<f32>;
@group(0) @binding(12) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(13) var<storage, read> params: array<u32>;

// Contacts of a tile that stay in registers.
const KEPT: u32 = 4u * THREADS;

// A contact in the registers of a thread: of its row what a visit needs, 1/a and 1/b, its impulse, the places of its bodies and its index.
struct Own {
    normal: vec3<f32>,
    offset: f32,
    reach: vec2<f32>,
    inverse: vec2<f32>,
    gamma: vec3<f32>,
    friction: f32,
    at: u32,
    k: u32,
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

// The contact of a visit of the tile whose contacts begin at `base`, if there is such a visit.
fn contact_at(base: u32, i: u32, n: u32) -> Own {
    var own: Own;
    if i < n {
        let visit = order[base + i];
        own.k = base + (visit.x & 0xffffu);
        own.at = visit.y;
        let row = rows[own.k];
        own.normal = row.normal;
        own.offset = row.offset;
        own.reach = row.reach;
        own.friction = row.friction;
        own.gamma = gamma[own.k].xyz;
        let places = vec2(own.at & 0xffffu, own.at >> 16u);
        let p = vec2(linear_of(places.x).w, angular_of(places.x).w);
        let q = vec2(linear_of(places.y).w, angular_of(places.y).w);
        own.inverse = inverse_of(row, vec2(p.x, q.x), vec2(p.y, q.y));
    }
    return own;
}

// Visit a contact. In the first sweep its residual term squared is left.
fn visit(own: ptr<function, Own>, is_first: bool) {
    var row: Row;
    row.normal = (*own).normal;
    row.offset = (*own).offset;
    row.reach = (*own).reach;
    row.friction = (*own).friction;
    let places = vec2((*own).at & 0xffffu, (*own).at >> 16u);
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
    if is_first {
        // The trace of N_ii, three times the reciprocal of η.
        let trace = 1.0 / (*own).inverse.x + 2.0 / (*own).inverse.y;
        terms[(*own).k] = dot(d, d) * trace * trace / 9.0;
    }
}

fn sweep_tile(tile: u32, thread: u32) {
    let first_pair = tile_first[tile];
    let base = place[first_pair];
    let size = tile_size[tile];
    let n = size.y;
    workgroupBarrier();
    for (var i = thread; i < size.x; i += THREADS) {
        let body = motion[tile_body[2u * first_pair + i]];
        linear[i] = vec4(body.v, body.inv_mass);
        angular[i] = vec4(body.w, body.inv_inertia);
    }
    workgroupBarrier();
    var own0 = contact_at(base, thread, n);
    var own1 = contact_at(base, thread + THREADS, n);
    var own2 = contact_at(base, thread + 2u * THREADS, n);
    var own3 = contact_at(base, thread + 3u * THREADS, n);
    for (var sweep = 0u; sweep < params[1]; sweep++) {
        let is_first = sweep == 0u;
        var at = 0u;
        var end = order[base].x >> 16u;
        while at < n {
            // The end of the next colour, while this one is visited.
            let next = order[base + min(end, n - 1u)].x >> 16u;
            workgroupBarrier();
            if thread >= at && thread < end {
                visit(&own0, is_first);
            }
            if n > THREADS {
                if thread + THREADS >= at && thread + THREADS < end {
                    visit(&own1, is_first);
                }
                if thread + 2u * THREADS >= at && thread + 2u * THREADS < end {
                    visit(&own2, is_first);
                }
                if thread + 3u * THREADS >= at && thread + 3u * THREADS < end {
                    visit(&own3, is_first);
                }
            }
            // Those that are not kept.
            for (var i = KEPT + thread; i < end; i += THREADS) {
                if i >= at {
                    var other = contact_at(base, i, n);
                    visit(&other, is_first);
                    gamma[other.k] = vec4(other.gamma, 0.0);
                }
            }
            at = end;
            end = next;
        }
    }
    if thread < n {
        gamma[own0.k] = vec4(own0.gamma, 0.0);
    }
    if thread + THREADS < n {
        gamma[own1.k] = vec4(own1.gamma, 0.0);
    }
    if thread + 2u * THREADS < n {
        gamma[own2.k] = vec4(own2.gamma, 0.0);
    }
    if thread + 3u * THREADS < n {
        gamma[own3.k] = vec4(own3.gamma, 0.0);
    }
    storageBarrier();
    workgroupBarrier();
    for (var i = thread; i < size.x; i += THREADS) {
        let body = tile_body[2u * first_pair + i];
        motion[body] = Body(linear[i].xyz, linear[i].w, angular[i].xyz, angular[i].w);
    }
    // In the order of the contacts, whatever that of the visits has been.
    var term = 0.0;
    for (var i = thread; i < n; i += THREADS) {
        term += terms[base + i];
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
