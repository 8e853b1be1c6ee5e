// Put the visits of each tile of spheres together that are made, of pairs that touch, in their order, with what a visit needs of its contact, a workgroup
// for each tile: sweeps read them one after the other.
// in   tiles       [n_tiles]     of `tile_order`
// in   order       [n_pairs]     of `tile_order`
// in   place       [n_pairs + 1] number of contacts of the pairs before each pair
// in   round_start [10]          first tile of each round
// in   rows        [n_contacts]
// in   motion      [n_bodies]    with reciprocal masses
// in   gamma       [n_contacts]  N s, world
// out  visits      [n_pairs]     of each tile, from its first pair on
// out  impulses    [n_pairs]     the same: N s, world
// out  contact_of  [n_pairs]     the same: the contact
// out  swept       [n_tiles]     `tiles` with the number of visits that are made
// in   params      [4]           the index of this dispatch and the number of dispatches; number of rounds; whether Coulomb's law is exact
// Twin: cpu/solve/sphere_group.rs
#import group_sum
#import sphere
#import visit
#import tile_visit

@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> round_start: array<u32>;
@group(0) @binding(4) var<storage, read> rows: array<Row>;
@group(0) @binding(5) var<storage, read> motion: array<Body>;
@group(0) @binding(6) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> visits: array<TileVisit>;
@group(0) @binding(8) var<storage, read_write> impulses: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> contact_of: array<u32>;
@group(0) @binding(10) var<storage, read_write> swept: array<vec4<u32>>;
@group(0) @binding(11) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;

// A place of nine bits.
fn place_bits(place: u32) -> u32 {
    return min(place, MOST_BODIES);
}

fn touches(pair: u32) -> bool {
    return place[pair + 1u] > place[pair];
}

// Put a visit to a contact at an index.
fn put(at: u32, visit: vec2<u32>, k: u32) {
    let row = rows[k];
    let of_tile = place_bits(visit.y & 0xffffu) | (place_bits(visit.y >> 16u) << 9u) | ((visit.x >> 16u) << 18u);
    let a = motion[row.bodies.x];
    let b = motion[row.bodies.y];
    let moment = vec2(a.inv_inertia, b.inv_inertia);
    let metric = metric_of(row, vec2(a.inv_mass, b.inv_mass), moment, params[3] == 1u);
    let cone = bitcast<vec3<u32>>(vec3(row.friction, metric.zw));
    visits[at] = TileVisit(vec4(row.normal, row.offset), vec4(row.reach, metric.xy), vec4(cone, of_tile));
    impulses[at] = gamma[k];
    contact_of[at] = k;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, lane: Lane) {
    let thread = thread_of(lane);
    for (var tile = group.x * params[1] + params[0]; tile < round_start[params[2]]; tile += groups.x * params[1]) {
        let own = tiles[tile];
        // A thread has some that follow each other.
        let some = (own.y + THREADS - 1u) / THREADS;
        let begin = own.x + min(thread * some, own.y);
        let end = own.x + min((thread + 1u) * some, own.y);
        var n = 0u;
        for (var i = begin; i < end; i++) {
            n += select(0u, 1u, touches(own.x + (order[i].x & 0xffffu)));
        }
        let before = group_sum(lane, n);
        var at = own.x + before.x;
        for (var i = begin; i < end; i++) {
            let visit = order[i];
            let pair = own.x + (visit.x & 0xffffu);
            if touches(pair) {
                put(at, visit, place[pair]);
                at++;
            }
        }
        if thread == 0u {
            swept[tile] = vec4(own.x, before.y, own.zw);
        }
        workgroupBarrier();
    }
}
