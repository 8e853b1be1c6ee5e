// Gauss–Seidel over the tiles of a round of spheres, a workgroup of `THREADS` for each: the tile's bodies are loaded into the memory of the workgroup,
// each thread takes up to four visits, which are made colour by colour several times, and all is written back once; visits beyond those, of the most
// crowded tiles, stay in memory. The tiles of a round share no moving body. With the columns of the kernel: visits, tiles, tile_body, round_start, motion,
// impulses, moved, scalars and params of tile_sweep.wgsl.
#import visit
#import tile_visit
#import scalars
#import tile_bodies

// Visits of a tile that stay in registers.
const KEPT: u32 = 4u * THREADS;

// A visit in the registers of a thread, and its impulse.
struct Own {
    visit: TileVisit,
    impulse: vec3<f32>,
}

fn color_of(visit: TileVisit) -> u32 {
    return visit.cone.w >> 18u;
}

// The visit of an index of the tile whose visits begin at `base`; one of no colour if there is no such.
fn visit_at(base: u32, i: u32, n: u32) -> Own {
    var own: Own;
    own.visit.cone.w = NO_VISIT;
    if i < n {
        own.visit = visits[base + i];
        own.impulse = impulses[base + i].xyz;
    }
    return own;
}

// Make a visit. Returns its residual term squared where that is wanted, in the first sweep: its divisions take as long as a third of the visit.
fn visit(own: ptr<function, Own>, is_first: bool) -> f32 {
    let n = (*own).visit.normal.xyz;
    let arms = (*own).visit.arms;
    let cone = bitcast<vec3<f32>>((*own).visit.cone.xyz);
    let packed = (*own).visit.cone.w;
    let a = min(packed & 511u, ROOM);
    let b = min((packed >> 9u) & 511u, ROOM);
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
    if !is_first {
        return 0.0;
    }
    // The trace of N_ii, three times the reciprocal of η.
    let trace = 1.0 / arms.z + 2.0 / arms.w;
    return dot(d, d) * trace * trace / 9.0;
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
        linear[ROOM] = vec4(0.0);
        angular[ROOM] = vec4(0.0);
    }
    var own0 = visit_at(base, thread, n);
    var own1 = visit_at(base, thread + THREADS, n);
    var own2 = visit_at(base, thread + 2u * THREADS, n);
    var own3 = visit_at(base, thread + 3u * THREADS, n);
    // The first colour of visits that stay in memory: the last of the order.
    var beyond = n_colors;
    if n > KEPT {
        beyond = color_of(visits[base + KEPT]);
    }
    // The residual terms of the first sweep.
    var term = 0.0;
    for (var sweep = 0u; sweep < params[3]; sweep++) {
        let is_first = sweep == 0u;
        for (var color = 0u; color < n_colors; color++) {
            workgroupBarrier();
            if color_of(own0.visit) == color {
                term += visit(&own0, is_first);
            }
            if color_of(own1.visit) == color {
                term += visit(&own1, is_first);
            }
            if color_of(own2.visit) == color {
                term += visit(&own2, is_first);
            }
            if color_of(own3.visit) == color {
                term += visit(&own3, is_first);
            }
            if color >= beyond {
                for (var i = KEPT + thread; i < n; i += THREADS) {
                    if color_of(visits[base + i]) == color {
                        var other = visit_at(base, i, n);
                        term += visit(&other, is_first);
                        impulses[base + i] = vec4(other.impulse, 0.0);
                    }
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
    let total = tile_total(thread, term);
    if thread == 0u {
        moved[tile] = total;
    }
}
