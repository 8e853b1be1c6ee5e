// The beginning of a solve by a descent method.
#import scalars
#import partial

const MAX_STEP: f32 = 1e6;

// The scalars of the first iteration; the step length of the last solve is kept.
fn begun(last: Scalars, n_contacts: u32, omega: f32) -> Scalars {
    var s = last;
    // In the metric of η the trace of N is 3 n_contacts: the least step is short enough for any direction.
    let least = 1.0 / (3.0 * f32(max(blocks_of(n_contacts), 1u)));
    s.step = select(1.0, s.step, s.step >= least && s.step <= MAX_STEP);
    s.theta = 1.0;
    s.beta = 0.0;
    s.accepted = 0u;
    s.kept = 1000u;
    s.trials = 0u;
    s.best = 3e38;
    s.is_current = 1u;
    s.half = 0u;
    s.omega = omega;
    s.last_step2 = 3e38;
    s.residual = 0.0;
    return s;
}
