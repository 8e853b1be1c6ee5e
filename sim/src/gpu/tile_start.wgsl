// Gauss–Seidel begins: the most passes, and the workgroups of a pass.
// inout scalars      [1]
// out   work         [2]  workgroups of the joints and of `closing`
// in    count        [1]  n_contacts
// in    params       [2]  the most iterations, 0 for the default; whether a pass stands for two
// Twin: gauss_seidel.rs, passes
#import scalars

@group(0) @binding(0) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(1) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let n = count[0];
    let most = max_iterations(params[0], blocks_of(n));
    scalars[0].limit = select(most, most / 2u + 1u, params[1] == 1u);
    scalars[0].trials = 0u;
    scalars[0].goes_on = select(0u, 1u, n > 0u);
    scalars[0].residual = 0.0;
    work[0] = vec4(select(0u, 1u, n > 0u), 1u, 1u, 0u);
    work[1] = vec4(0u, 0u, 1u, 0u);
}
