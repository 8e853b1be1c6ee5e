// APGD: whether an iterate is the best so far, and whether it is within the tolerance, or within what rounding leaves.
// in    parts    [n_groups]  residual terms squared, and what of them is rounding, m²/s²
// inout scalars  [1]
// inout work     [5]         workgroups of an iteration, of a check and of what is kept
// in    count    [1]         n_contacts
// in    params   [3]         n_bodies; as bits the tolerance (m/s); whether the solve is at its end
// Twin: cpu/solve/iterates.rs
#import scalars
#import parts_total

@group(0) @binding(0) var<storage, read> parts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(2) var<storage, read_write> work: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    // Once the solve has ended, nothing is checked until all is.
    let is_due = work[2].x > 0u || params[2] == 1u;
    let n_parts = select(0u, groups_of(count[0]), is_due);
    let sums = parts_total(thread, n_parts);
    if thread != 0u {
        return;
    }
    let none = vec4(0u, 0u, 1u, 0u);
    work[3] = none;
    work[4] = none;
    if !is_due {
        return;
    }
    var s = scalars[0];
    let n = f32(max(blocks_of(count[0]), 1u));
    let residual = sqrt(sums.x) / n;
    let tolerance = bitcast<f32>(params[1]);
    s.is_current = select(0u, 1u, residual <= s.best);
    if s.is_current == 1u {
        s.best = residual;
        work[3] = dispatch_of(count[0]);
        work[4] = dispatch_of(params[0]);
    }
    if residual <= select(0.0, max(tolerance, sqrt(sums.y) / n), tolerance > 0.0) {
        s.goes_on = 0u;
        work[0] = none;
        work[1] = none;
        work[2] = none;
    }
    scalars[0] = s;
}
