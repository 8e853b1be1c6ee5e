// Gauss–Seidel begins: the most iterations, and the workgroups of an iteration.
// inout scalars      [1]
// out   work         [11]  workgroups of each dispatch of a round, of the big tiles, of the joints and of `closing`
// in    round_start  [10]  first tile of each round
// in    n_big        [1]
// in    count        [1]   n_contacts
// in    params       [2]   the most iterations, 0 for the default; the number of dispatches of a round
#import scalars

@group(0) @binding(0) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(1) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> round_start: array<u32>;
@group(0) @binding(3) var<storage, read> n_big: array<u32>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

@compute @workgroup_size(16)
fn main(@builtin(local_invocation_index) thread: u32) {
    let n = count[0];
    if thread == 0u {
        scalars[0].limit = max_iterations(params[0], blocks_of(n));
        scalars[0].trials = 0u;
        scalars[0].goes_on = select(0u, 1u, n > 0u);
        scalars[0].residual = 0.0;
    }
    if thread < 8u {
        let n_tiles = select(0u, round_start[thread + 1u] - round_start[thread], n > 0u);
        let groups = (n_tiles + params[1] - 1u) / params[1];
        work[thread] = vec4(min(groups, 65535u), groups / 65535u + select(0u, 1u, groups % 65535u != 0u), 1u, 0u);
    }
    if thread == 8u {
        work[8] = vec4(select(0u, 1u, n > 0u && n_big[0] > 0u), 1u, 1u, 0u);
    }
    if thread == 9u {
        work[9] = vec4(select(0u, 1u, n > 0u), 1u, 1u, 0u);
    }
    if thread == 10u {
        work[10] = vec4(0u, 0u, 1u, 0u);
    }
}
