//! Coulomb's law itself: the gap's rate is fed with the slip μ|v_t| (Cadoux 2009; Acary et al. 2011), and the convex problem is
//! solved anew until the slip that was fed is the slip that comes out.

use super::*;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    limit: Limit,
    gamma: &mut Vec<DVec3>,
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    const ROUNDS: u32 = 40;
    let mut slip = std::mem::take(&mut work.slip);
    slip.resize(gamma.len(), 0.0);
    let mut total = Outcome::default();
    let share = (limit.iterations / 4).max(1);
    // The slip of the start is the first guess.
    let mut fed = vec![0.0; gamma.len()];
    for round in 0..ROUNDS {
        measure(op, image, &mut slip);
        let change: f64 = slip.iter().zip(&fed).map(|(a, b)| (a - b).abs()).sum();
        let sum: f64 = slip.iter().sum();
        let settled = change <= 1e-9 * sum + 1e-2 * limit.tolerance * gamma.len() as f64;
        if round > 0 && (settled || total.iterations >= limit.iterations) {
            break;
        }
        fed.clone_from(&slip);
        op.feed(&fed);
        op.image(gamma, image);
        let budget =
            Limit { iterations: share.min(limit.iterations - total.iterations.min(limit.iterations - 1)), ..limit };
        let outcome = super::run(op, settings, budget, gamma, image, work);
        total = Outcome { iterations: total.iterations + outcome.iterations, residual: outcome.residual };
    }
    work.slip = slip;
    total
}

/// μ |v_t| of every block; the gradient's normal part has no share in it.
fn measure(op: &impl Operator, image: &Image, slip: &mut [f64]) {
    fill_rows(slip, |i| {
        let (mu, normal) = op.friction(i);
        let v = op.pull(image, i);
        mu * (v - normal * v.dot(normal)).length()
    });
}
