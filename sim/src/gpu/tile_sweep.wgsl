// Gauss–Seidel over the tiles of a round, a workgroup for each: the tile's bodies are loaded into the memory of the workgroup, each thread
// takes up to four visits, which are made colour by colour several times, and all is written back once; visits beyond those stay in memory. The
// tiles of a round share no moving body.
// in    visits       [n_contacts]  of each tile, from its first contact on, in the order of colours
// in    tiles        [n_tiles]     first contact, number of visits, place of the first body in the list, numbers of bodies and of colours
// in    tile_body    [2 n_pairs]   bodies of each tile
// in    round_start  [10]          first tile of each round
// inout motion       [n_bodies]    m/s, rad/s
// inout impulses     [n_contacts]  of the visits: N s, world
// out   moved        [n_tiles]     residual terms of the first sweep squared, m²/s²
// in    scalars      [1]
// in    params       [5]           round, the index of this dispatch and the number of dispatches of a round, sweeps, and as bits ω
// Twin: cpu/solve/sweeps.rs
#import sphere
#import visit
#import tile_visit
#import scalars
#import tile_bodies

@group(0) @binding(0) var<storage, read> visits: array<TileVisit>;
@group(0) @binding(1) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> tile_body: array<u32>;
@group(0) @binding(3) var<storage, read> round_start: array<u32>;
@group(0) @binding(4) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(5) var<storage, read_write> impulses: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> moved: array<f32>;
@group(0) @binding(7) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

const THREADS: u32 = 128u;
// Visits of a tile that stay in registers.
const KEPT: u32 = 4u * THREADS;
const NONE: u32 = 0xffffffffu;

// A visit in the registers of a thread, with its impulse and its residual term squared in the first sweep.
struct Own {
    visit: TileVisit,
    impulse: vec3<f32>,
    term: f32,
}

fn color_of(visit: TileVisit) -> u32 {
    return visit.cone.w >> 18u;
}

// The visit of an index of the tile whose contacts begin at `base`; one of no colour if there is no such.
fn visit_at(base: u32, i: u32, n: u32) -> Own {
    var own: Own;
    own.visit.cone.w = NONE;
    if i < n {
        own.visit = visits[base + i];
        own.impulse = impulses[base + i].xyz;
    }
    return own;
}

// Make a visit.
fn visit(own: ptr<function, Own>, is_first: bool) {
    let n = (*own).visit.normal.xyz;
    let arms = (*own).visit.arms;
    let cone = bitcast<vec3<f32>>((*own).visit.cone.xyz);
    let a = (*own).visit.cone.w & 511u;
    let b = ((*own).visit.cone.w >> 9u) & 511u;
    let va = linear[a];
    let vb = linear[b];
    let wa = angular[a];
    let wb = angular[b];
    let gradient = vb.xyz - va.xyz + n * (*own).visit.normal.w + cross(n, wa.xyz * arms.x + wb.xyz * arms.y);
    let z = visited(n, cone.x, (*own).impulse, gradient, vec4(arms.zw, cone.yz));
    let d = (z - (*own).impulse) * bitcast<f32>(params[4]);
    (*own).impulse += d;
    let spin = cross(n, d);
    // What is held is written as it was.
    linear[a] = vec4(va.xyz - d * va.w, va.w);
    angular[a] = vec4(wa.xyz - spin * (arms.x * wa.w), wa.w);
    linear[b] = vec4(vb.xyz + d * vb.w, vb.w);
    angular[b] = vec4(wb.xyz - spin * (arms.y * wb.w), wb.w);
    if is_first {
        // The trace of N_ii, three times the reciprocal of η.
        let trace = 1.0 / arms.z + 2.0 / arms.w;
        (*own).term = dot(d, d) * trace * trace / 9.0;
    }
}

// Load the bodies of a tile, those of a thread together: it waits for memory once.
fn load_bodies(first: u32, n: u32, thread: u32) {
    let last = first + n - 1u;
    let body0 = motion[tile_body[min(first + thread, last)]];
    let body1 = motion[tile_body[min(first + thread + THREADS, last)]];
    let body2 = motion[tile_body[min(first + thread + 2u * THREADS, last)]];
    let body3 = motion[tile_body[min(first + thread + 3u * THREADS, last)]];
    put_body(thread, n, body0);
    put_body(thread + THREADS, n, body1);
    put_body(thread + 2u * THREADS, n, body2);
    put_body(thread + 3u * THREADS, n, body3);
}

fn put_body(at: u32, n: u32, body: BodyRow) {
    if at < n {
        linear[at] = body.linear;
        angular[at] = body.angular;
    }
}

fn is_due(tile: u32) -> bool {
    return true;
}

fn sweep_tile(tile: u32, thread: u32) {
    let base = tiles[tile].x;
    let n = tiles[tile].y;
    let first_body = tiles[tile].z;
    let n_bodies = tiles[tile].w & 0xffffu;
    let n_colors = tiles[tile].w >> 16u;
    workgroupBarrier();
    load_bodies(first_body, n_bodies, thread);
    if thread == 0u {
        linear[MOST_BODIES] = vec4(0.0);
        angular[MOST_BODIES] = vec4(0.0);
    }
    var own0 = visit_at(base, thread, n);
    var own1 = visit_at(base, thread + THREADS, n);
    var own2 = visit_at(base, thread + 2u * THREADS, n);
    var own3 = visit_at(base, thread + 3u * THREADS, n);
    // The terms of those that are not kept.
    var term = 0.0;
    for (var sweep = 0u; sweep < params[3]; sweep++) {
        let is_first = sweep == 0u;
        for (var color = 0u; color < n_colors; color++) {
            workgroupBarrier();
            if color_of(own0.visit) == color {
                visit(&own0, is_first);
            }
            if color_of(own1.visit) == color {
                visit(&own1, is_first);
            }
            if color_of(own2.visit) == color {
                visit(&own2, is_first);
            }
            if color_of(own3.visit) == color {
                visit(&own3, is_first);
            }
            for (var i = KEPT + thread; i < n; i += THREADS) {
                if color_of(visits[base + i]) == color {
                    var other = visit_at(base, i, n);
                    visit(&other, is_first);
                    impulses[base + i] = vec4(other.impulse, 0.0);
                    term += other.term;
                }
            }
        }
    }
    if thread < n {
        impulses[base + thread] = vec4(own0.impulse, 0.0);
    }
    if thread + THREADS < n {
        impulses[base + thread + THREADS] = vec4(own1.impulse, 0.0);
    }
    if thread + 2u * THREADS < n {
        impulses[base + thread + 2u * THREADS] = vec4(own2.impulse, 0.0);
    }
    if thread + 3u * THREADS < n {
        impulses[base + thread + 3u * THREADS] = vec4(own3.impulse, 0.0);
    }
    workgroupBarrier();
    for (var i = thread; i < n_bodies; i += THREADS) {
        motion[tile_body[first_body + i]] = BodyRow(linear[i], angular[i]);
    }
    let total = tile_total(thread, term + (own0.term + own1.term) + (own2.term + own3.term));
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
