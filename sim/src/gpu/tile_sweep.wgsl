// Gauss–Seidel over the tiles of the first round of spheres, which have most of the pairs: `tile_spheres`, by workgroups of 160.
// in    visits       [n_pairs]     of each tile, from its first pair on, in the order of colours
// in    tiles        [n_tiles]     first pair, number of visits, place of the first body in the list, numbers of bodies and of colours
// in    tile_body    [2 n_pairs]   bodies of each tile
// in    round_start  [10]          first tile of each round
// inout motion       [n_bodies]    m/s, rad/s
// inout impulses     [n_pairs]     of the visits: N s, world
// out   moved        [n_tiles]     residual terms of the first sweep squared, m²/s²
// in    scalars      [1]
// in    params       [5]           round, the index of this dispatch and the number of dispatches of a round, sweeps, and as bits ω
// Twin: cpu/solve/sweeps.rs
#import sphere
#import tile_spheres

@group(0) @binding(0) var<storage, read> visits: array<TileVisit>;
@group(0) @binding(1) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> tile_body: array<u32>;
@group(0) @binding(3) var<storage, read> round_start: array<u32>;
@group(0) @binding(4) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(5) var<storage, read_write> impulses: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> moved: array<f32>;
@group(0) @binding(7) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

const THREADS: u32 = 160u;
const ROOM: u32 = MOST_BODIES;

@compute @workgroup_size(160)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    sweep_round(group.x, groups.x, thread);
}
