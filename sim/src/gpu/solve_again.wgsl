// A round of the solve begins, with another slip fed back.
// inout scalars  [1]
// out   work     [5]  workgroups of an iteration over contacts and over bodies, of a check and of what is kept
// in    limit    [1]  the most iterations of the round
// in    count    [1]  n_contacts
// in    params   [2]  n_bodies, and as bits the first step length of Barzilai–Borwein
// Twin: cpu/solve/exact.rs
#import begin_solve

@group(0) @binding(0) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(1) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> limit: array<u32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    var s = begun(scalars[0], count[0], bitcast<f32>(params[1]));
    s.goes_on = select(0u, 1u, count[0] > 0u);
    s.limit = limit[0];
    scalars[0] = s;
    work[0] = dispatch_of(count[0]);
    work[1] = dispatch_of(params[0]);
    work[2] = work[0];
    work[3] = vec4(0u, 0u, 1u, 0u);
    work[4] = work[3];
}
