// APGD: whether a trial is taken, and the scalars of the next.
// in    sums     [3]  |z − y|²/η, (N y + r)·(z − x) and dᵀNd with d = z − y, J, each a buffer of one
// inout scalars  [1]
// in    count    [1]  n_contacts
// in    params   [1]  number of trials
// Twin: cpu/solve/apgd.rs
#import apgd_scalars

@group(0) @binding(0) var<storage, read> moved: array<f32>;
@group(0) @binding(1) var<storage, read> slope: array<f32>;
@group(0) @binding(2) var<storage, read> curvature: array<f32>;
@group(0) @binding(3) var<storage, read_write> scalars: array<Scalars>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

const MAX_STEP: f32 = 1e6;
// Trials that a step length is kept after one that was too long.
const KEEP: u32 = 10u;

@compute @workgroup_size(1)
fn main() {
    var s = scalars[0];
    s.trials++;
    let least = 1.0 / (3.0 * f32(max(count[0], 1u)));
    // Restart where the step is uphill.
    let is_uphill = slope[0] > 0.0;
    let next_theta = 0.5 * (s.theta * sqrt(s.theta * s.theta + 4.0) - s.theta * s.theta);
    let next_beta = select(s.theta * (1.0 - s.theta) / (s.theta * s.theta + next_theta), 0.0, is_uphill);
    // Short enough if ½ dᵀNd ≤ |d|²/(2 t) in the metric of η, to the rounding of the sums.
    let fits = curvature[0] * s.step <= moved[0] * (1.0 + 1e-5);
    if fits || s.step <= least || s.trials >= params[0] {
        s.accepted = 1u;
        s.beta = next_beta;
        s.theta = select(next_theta, 1.0, is_uphill);
        s.kept++;
        if s.kept > KEEP && curvature[0] > 0.0 {
            s.step = min(1.1 * s.step, MAX_STEP);
        }
    } else {
        s.accepted = 0u;
        s.kept = 0u;
        s.step = max(min(0.95 * moved[0] / curvature[0], 0.95 * s.step), least);
    }
    scalars[0] = s;
}
