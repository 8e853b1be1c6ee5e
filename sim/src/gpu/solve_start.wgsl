// A solve begins: the factor of the starting point is settled, and the scalars are those of the first iteration.
// in    parts    [n_groups]  m/s: lengths of the residual terms with the starting point as it is and scaled
// inout scalars  [1]         the step length of the last solve in
// out   work     [5]         workgroups of an iteration over contacts and over bodies, of a check and of what is kept
// in    count    [1]         n_contacts
// in    params   [2]         n_bodies, and as bits the first step length of Jacobi or Barzilai–Borwein
// Twin: cpu/solve/scale.rs
#import begin_solve

@group(0) @binding(0) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var lengths = vec4(0.0);
    for (var i = thread; i < groups_of(count[0]); i += 256u) {
        lengths += parts[i];
    }
    lengths = group_total(thread, lengths);
    if thread != 0u {
        return;
    }
    var s = scalars[0];
    let n = count[0];
    if blocks_of(n) > s.limit && lengths.x < lengths.y {
        s.factor = 1.0;
    }
    // Zero impulses may be the solution.
    let is_idle = s.last_step2 == 0.0 && lengths.x == 0.0;
    s.goes_on = select(1u, 0u, n == 0u || is_idle);
    scalars[0] = begun(s, n, bitcast<f32>(params[1]));
    let is_active = s.goes_on == 1u;
    work[0] = dispatch_of(select(0u, n, is_active));
    work[1] = dispatch_of(select(0u, params[0], is_active));
    work[2] = work[0];
    work[3] = vec4(0u, 0u, 1u, 0u);
    work[4] = work[3];
}
