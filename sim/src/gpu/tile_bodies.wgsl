// The memory of the workgroups of 128 that sweep tiles, and the tiles of a round, which each of them sweeps one after the other: with `sweep_tile` of the
// kernel and its columns `round_start`, `is_big`, `tile_size`, `moved`, `scalars` and `params`.

const THREADS: u32 = 128u;
// The place of a body that is held.
const NOWHERE: u32 = 0xffffu;

// Velocities of the tile's bodies with their reciprocal masses, and angular velocities; of spheres with reciprocal moments of inertia.
var<workgroup> linear: array<vec4<f32>, 480>;
var<workgroup> angular: array<vec4<f32>, 480>;

var<workgroup> sums: array<f32, 128>;

// The sum of a term over the threads of the workgroup, in thread 0. All threads call it.
fn tile_total(thread: u32, term: f32) -> f32 {
    sums[thread] = term;
    for (var step = 1u; step < THREADS; step <<= 1u) {
        workgroupBarrier();
        if thread % (2u * step) == 0u {
            sums[thread] += sums[thread + step];
        }
    }
    return sums[thread];
}

// Sweep the tiles of the round of `params`, those of one of the workgroups; none once the solve has ended.
fn sweep_round(group: u32, n_groups: u32, thread: u32) {
    let end = select(round_start[params[0]], round_start[params[0] + 1u], scalars[0].goes_on == 1u);
    let first = round_start[params[0]] + group * params[5] + params[4];
    for (var tile = first; tile < end; tile += n_groups * params[5]) {
        if is_big[tile] == 0u && tile_size[tile].y > 0u {
            sweep_tile(tile, thread);
        } else if thread == 0u {
            moved[tile] = 0.0;
        }
    }
}
