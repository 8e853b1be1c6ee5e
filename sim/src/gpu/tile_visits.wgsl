// Put the visits of each tile of spheres together, in their order, with what a visit needs of its contact, a workgroup for each tile: sweeps read
// them one after the other.
// in   tiles       [n_tiles]     first contact, number of visits, place of the first body in the list, numbers of bodies and of colours
// in   order       [n_contacts]  of `tile_color`
// in   round_start [10]          first tile of each round
// in   rows        [n_contacts]
// in   motion      [n_bodies]    with reciprocal masses
// in   gamma       [n_contacts]  N s, world
// out  visits      [n_contacts]  of each tile, from its first contact on
// out  impulses    [n_contacts]  the same: N s, world
// in   params      [4]           the index of this dispatch and the number of dispatches; number of rounds; whether Coulomb's law is exact
// Twin: cpu/solve/sphere_group.rs
#import sphere
#import visit
#import tile_visit

@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> round_start: array<u32>;
@group(0) @binding(3) var<storage, read> rows: array<Row>;
@group(0) @binding(4) var<storage, read> motion: array<Body>;
@group(0) @binding(5) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> visits: array<TileVisit>;
@group(0) @binding(7) var<storage, read_write> impulses: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

// A place of nine bits.
fn place_bits(place: u32) -> u32 {
    return min(place, MOST_BODIES);
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var tile = group.x * params[1] + params[0]; tile < round_start[params[2]]; tile += groups.x * params[1]) {
        let base = tiles[tile].x;
        let end = base + tiles[tile].y;
        for (var i = base + thread; i < end; i += 256u) {
            let visit = order[i];
            let contact = visit.x & 0xffffu;
            let row = rows[base + contact];
            let a = motion[row.bodies.x];
            let b = motion[row.bodies.y];
            let moment = vec2(a.inv_inertia, b.inv_inertia);
            let metric = metric_of(row, vec2(a.inv_mass, b.inv_mass), moment, params[3] == 1u);
            let cone = vec3(row.friction, metric.zw);
            let normal = vec4(row.normal, row.offset);
            let of_tile = place_bits(visit.y & 0xffffu) | (place_bits(visit.y >> 16u) << 9u) | ((visit.x >> 16u) << 18u);
            visits[i] = TileVisit(normal, vec4(row.reach, metric.xy), vec4(bitcast<vec3<u32>>(cone), of_tile));
            impulses[i] = gamma[base + contact];
        }
    }
}
