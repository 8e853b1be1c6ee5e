// Gauss–Seidel over the pairs of big tiles and those in no tile of shapes of any kind, one tile after the other, by one workgroup on the
// columns in memory; and, where no joints follow, whether another iteration does.
// in    rows         [n_contacts]
// in    visits       [n_contacts]
// in    place        [n_pairs + 1] number of contacts of the pairs before each pair
// in    order        [n_pairs]     pairs of each big tile by their colours, from its first pair on
// in    ends         [2 n_pairs]   ends of its colours in this list, from twice its first pair on
// in    tile_first   [n_tiles]     first pair of each tile
// in    tile_size    [n_tiles]     number of pairs without a colour, and of colours
// in    big          [n_big]       the big tiles
// in    counts       [3]           n_big, n_tiles, n_pairs
// inout motion       [n_bodies]    m/s, rad/s
// inout gamma        [n_contacts]  N s, world
// out   rest_moved   [1]           residual terms of the first sweep squared, m²/s²; negative where the pairs are settled
// in    mass         [n_bodies]    1/kg, and principal, 1/(kg m²)
// in    orientation  [n_bodies]    of the principal frames
// inout roll         [n_contacts]  N m s, world: rolling and spinning impulses on B
// in    roll_row     [n_contacts]
// in    moved        [n_tiles]     the same of the other tiles
// in    round_start  [10]          first tile of each round
// inout work         [2]           workgroups of the joints and of `closing`
// in    count        [1]           n_contacts
// inout scalars      [1]
// in    params       [10]          sweeps, whether Coulomb's law is exact, and as bits ω; whether it is decided; as bits the tolerance (m/s),
//                                  whether `closing` decides once the iterations of the settings are done, number of rounds, and the most
//                                  iterations for slow bodies over those of the settings, 0 for none; as bits the squares of the residual of
//                                  slow bodies and of their speed, m²/s²
// Twin: cpu/solve/sweeps.rs
#import sphere
#import manifold
#import tile_decided
#import settling

@group(0) @binding(0) var<storage, read> rows: array<Row>;
@group(0) @binding(1) var<storage, read> visits: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read> order: array<u32>;
@group(0) @binding(4) var<storage, read> ends: array<u32>;
@group(0) @binding(5) var<storage, read> tile_first: array<u32>;
@group(0) @binding(6) var<storage, read> tile_size: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> big: array<u32>;
@group(0) @binding(8) var<storage, read> n_big: array<u32>;
@group(0) @binding(9) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(10) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(11) var<storage, read_write> motion: array<Body>;
@group(0) @binding(12) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> rest_moved: array<f32>;
@group(0) @binding(14) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(15) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read_write> roll: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read> roll_row: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read> moved: array<f32>;
@group(0) @binding(19) var<storage, read> round_start: array<u32>;
@group(0) @binding(20) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(21) var<storage, read> count: array<u32>;
@group(0) @binding(22) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(23) var<storage, read> params: array<u32>;

const THREADS: u32 = 256u;

// Visit the contacts of a pair. Returns their residual terms squared, whether a body is fast, and whether there are any contacts.
fn visit_pair(pair: u32) -> vec4<f32> {
    let first = place[pair];
    let end = place[pair + 1u];
    if first == end {
        return vec4(0.0);
    }
    let bodies = rows[first].bodies;
    let a = motion[bodies.x];
    let b = motion[bodies.y];
    var two = Two(a.v, a.inv_mass, a.w, b.inv_mass, b.v, b.w, tensor_of(bodies.x), tensor_of(bodies.y));
    var term = 0.0;
    for (var k = first; k < end; k++) {
        term += visit(k, &two, params[1] == 1u, bitcast<f32>(params[2]));
    }
    if a.inv_mass > 0.0 {
        motion[bodies.x] = Body(two.va, a.inv_mass, two.wa, a.inv_inertia);
    }
    if b.inv_mass > 0.0 {
        motion[bodies.y] = Body(two.vb, b.inv_mass, two.wb, b.inv_inertia);
    }
    let is_fast = max(dot(two.va, two.va), dot(two.vb, two.vb)) > bitcast<f32>(params[9]);
    return vec4(term, select(0.0, 1.0, is_fast), 1.0, 0.0);
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var terms = vec4(0.0);
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
                    terms += select(vec4(0.0), of_pair, sweep == 0u);
                }
                begin = of_color;
            }
            if tile_size[tile].x > 0u {
                storageBarrier();
                workgroupBarrier();
                for (var i = begin; i < select(begin, end, thread == 0u); i++) {
                    let of_pair = visit_pair(order[i]);
                    terms += select(vec4(0.0), of_pair, sweep == 0u);
                }
            }
        }
        storageBarrier();
        workgroupBarrier();
    }
    let total = group_total(thread, terms);
    let rest = settled(total.x, total.y, total.z, bitcast<f32>(params[8]));
    if thread == 0u {
        rest_moved[0] = rest;
    }
    if params[3] == 1u {
        decide(thread, rest, bitcast<f32>(params[4]), params[5] == 1u, params[6], params[7]);
    }
}
