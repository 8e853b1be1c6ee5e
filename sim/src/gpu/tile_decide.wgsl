// Gauss–Seidel: the residual of an iteration, and whether another follows.
// in    moved    [n_tiles]  residual terms squared, m²/s²
// in    rest     [1]        those of big tiles
// inout scalars  [1]
// inout work     [2]        workgroups of the joints and of `closing`
// in    counts   [2]        n_tiles, n_contacts
// in    params   [3]        as bits: tolerance (m/s); whether `closing` decides once the iterations of the settings are done; number of rounds
// Twin: cpu/solve/sweeps.rs
#import scalars
#import partial

@group(0) @binding(0) var<storage, read> moved: array<f32>;
@group(0) @binding(1) var<storage, read> rest: array<f32>;
@group(0) @binding(2) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> round_start: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let is_active = scalars[0].goes_on == 1u;
    var sums = vec4(0.0);
    let n_tiles = select(0u, round_start[params[2]], is_active);
    for (var i = thread; i < n_tiles; i += 1024u) {
        let first = vec4(moved[i], 0.0, 0.0, 0.0) + below(vec4(moved[min(i + 256u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 256u, n_tiles);
        sums += first + (below(vec4(moved[min(i + 512u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 512u, n_tiles) + below(vec4(moved[min(i + 768u, n_tiles - 1u)], 0.0, 0.0, 0.0), i + 768u, n_tiles));
    }
    sums = group_total(thread, sums);
    if thread != 0u || !is_active {
        return;
    }
    var s = scalars[0];
    s.trials++;
    s.residual = sqrt(sums.x + rest[0]) / f32(blocks_of(count[0]));
    let is_done = s.trials >= s.limit;
    if is_done && params[1] == 1u {
        work[1] = dispatch_of(count[0]);
    }
    if s.residual <= bitcast<f32>(params[0]) || (is_done && params[1] == 0u) {
        s.goes_on = 0u;
        work[0] = vec4(0u, 0u, 1u, 0u);
        work[1] = work[0];
    }
    scalars[0] = s;
}
