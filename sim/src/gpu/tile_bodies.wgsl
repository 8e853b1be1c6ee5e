// The memory of the workgroups that sweep tiles, and the tiles of a round, which each of them sweeps one after the other: with `THREADS`, `ROOM`, the most
// bodies of a tile, `sweep_tile` and `is_due`, whether a tile is swept in this iteration, of the kernel and its columns `round_start`, `tiles`, `moved`,
// `scalars` and `params`.

// Velocities of the tile's bodies with their reciprocal masses, and angular velocities; of spheres with reciprocal moments of inertia. The last
// is a body that is held, all of whose numbers are zero.
var<workgroup> linear: array<vec4<f32>, ROOM + 1>;
var<workgroup> angular: array<vec4<f32>, ROOM + 1>;

var<workgroup> sums: array<f32, THREADS>;

// The sum of a term over the threads of the workgroup, in thread 0. All threads call it.
fn tile_total(thread: u32, term: f32) -> f32 {
    sums[thread] = term;
    workgroupBarrier();
    var sum = 0.0;
    if thread < 8u {
        for (var i = thread; i < THREADS; i += 8u) {
            sum += sums[i];
        }
        sums[thread] = sum;
    }
    workgroupBarrier();
    if thread == 0u {
        for (var i = 1u; i < 8u; i++) {
            sum += sums[i];
        }
    }
    return sum;
}

// Sweep the tiles of a round, those of one of the workgroups; none once the solve has ended. `params` begin with the round, the index of this
// dispatch and the number of dispatches of a round.
fn sweep_round(group: u32, n_groups: u32, thread: u32) {
    let end = select(round_start[params[0]], round_start[params[0] + 1u], scalars[0].goes_on == 1u);
    let first = round_start[params[0]] + group * params[2] + params[1];
    for (var tile = first; tile < end; tile += n_groups * params[2]) {
        if tiles[tile].y == 0u {
            if thread == 0u {
                moved[tile] = 0.0;
            }
        } else if is_due(tile) {
            sweep_tile(tile, thread);
        }
    }
}
