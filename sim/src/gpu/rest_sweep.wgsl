// Gauss–Seidel over the contacts of big tiles and of pairs in no tile, one tile after the other, by one workgroup on the columns in memory;
// and, where no joints follow, whether another iteration does.
// in    rows         [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    order        [n_pairs]     pairs of each big tile by their colours, from its first pair on
// in    ends         [2 n_pairs]   ends of its colours in this list, from twice its first pair on
// in    tile_first   [n_tiles]     first pair of each tile
// in    tile_size    [n_tiles]     number of pairs without a colour, and of colours
// in    big          [n_big]       the big tiles
// in    counts       [3]           n_big, n_tiles, n_pairs
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// out   rest_moved   [1]           residual terms of the first sweep squared, m²/s²
// in    moved        [n_tiles]     the same of the other tiles
// in    round_start  [10]          first tile of each round
// inout work         [2]           workgroups of the joints and of `closing`
// in    count        [1]           n_contacts
// inout scalars      [1]
// in    params       [7]           sweeps, whether Coulomb's law is exact, and as bits ω; whether it is decided; as bits the tolerance (m/s),
//                                  whether `closing` decides once the iterations of the settings are done, and number of rounds
// Twin: cpu/solve/sweeps.rs
#import sphere
#import project
#import visit
#import tile_decided

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> place: array<u32>;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read> ends: array<u32>;
@group(0) @binding(4) var<storage, read> tile_first: array<u32>;
@group(0) @binding(5) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> big: array<u32>;
@group(0) @binding(7) var<storage, read> n_big: array<u32>;
@group(0) @binding(8) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(9) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(10) var<storage, read_write> motion: array<Body>;
@group(0) @binding(11) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> rest_moved: array<f32>;
@group(0) @binding(13) var<storage, read> moved: array<f32>;
@group(0) @binding(14) var<storage, read> round_start: array<u32>;
@group(0) @binding(15) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(16) var<storage, read> count: array<u32>;
@group(0) @binding(17) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(18) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;

// Visit the contact of a pair, if it touches. Returns its residual term squared.
fn visit_pair(pair: u32) -> f32 {
    let k = place[pair];
    if place[pair + 1u] == k {
        return 0.0;
    }
    let row = rows[k];
    let a = motion[row.bodies.x];
    let b = motion[row.bodies.y];
    let before = gamma[k].xyz;
    let moment = vec2(a.inv_inertia, b.inv_inertia);
    let metric = metric_of(row, vec2(a.inv_mass, b.inv_mass), moment, params[1] == 1u);
    let z = visited(row.normal, row.friction, before, gradient_of(row, a, b), metric);
    let d = (z - before) * bitcast<f32>(params[2]);
    gamma[k] = vec4(before + d, 0.0);
    let spin = cross(row.normal, d);
    if a.inv_mass > 0.0 {
        motion[row.bodies.x] = Body(a.v - d * a.inv_mass, a.inv_mass, a.w - spin * (row.reach.x * a.inv_inertia), a.inv_inertia);
    }
    if b.inv_mass > 0.0 {
        motion[row.bodies.y] = Body(b.v + d * b.inv_mass, b.inv_mass, b.w - spin * (row.reach.y * b.inv_inertia), b.inv_inertia);
    }
    return dot(d, d) / (row.eta * row.eta);
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var term = 0.0;
    let n_tiles_to_do = select(0u, n_big[0], scalars[0].goes_on == 1u);
    for (var t = 0u; t < n_tiles_to_do; t++) {
        let tile = big[t];
        let first = tile_first[tile];
        var end = n_pairs[0];
        if tile + 1u < n_tiles[0] {
            end = tile_first[tile + 1u];
        }
        for (var sweep = 0u; sweep < params[0]; sweep++) {
            var begin = first;
            for (var c = 0u; c < tile_size[tile].y; c++) {
                let of_color = first + ends[2u * first + c];
                storageBarrier();
                workgroupBarrier();
                for (var i = begin + thread; i < of_color; i += THREADS) {
                    let of_pair = visit_pair(order[i]);
                    term += select(0.0, of_pair, sweep == 0u);
                }
                begin = of_color;
            }
            if tile_size[tile].x > 0u {
                storageBarrier();
                workgroupBarrier();
                for (var i = begin; i < select(begin, end, thread == 0u); i++) {
                    let of_pair = visit_pair(order[i]);
                    term += select(0.0, of_pair, sweep == 0u);
                }
            }
        }
        storageBarrier();
        workgroupBarrier();
    }
    let total = group_total(thread, vec4(term, 0.0, 0.0, 0.0));
    if thread == 0u {
        rest_moved[0] = total.x;
    }
    if params[3] == 1u {
        decide(thread, total.x, bitcast<f32>(params[4]), params[5] == 1u, params[6], 0u);
    }
}
