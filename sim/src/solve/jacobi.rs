//! The paper's Algorithm 1, γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, with the joints eliminated rather than iterated.

use super::*;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    let (omega, lambda) = (settings.omega.unwrap_or(0.3), settings.lambda);
    work.next.resize(gamma.len(), DVec3::ZERO);
    let mut outcome = Outcome::default();
    let most = settings.most_iterations(gamma.len());
    for iteration in 1..=most {
        let (now, x, im) = (&*op, &*gamma, &*image);
        fill_rows(&mut work.next, |i| {
            let stepped = x[i] - now.pull(im, i) * (omega * now.eta(i));
            now.project(i, stepped, x) * lambda + x[i] * (1.0 - lambda)
        });
        std::mem::swap(gamma, &mut work.next);
        op.image(gamma, image);
        outcome.iterations = iteration;
        if settings.tolerance > 0.0 || iteration == most {
            outcome.residual = residual(op, gamma, image);
            if outcome.residual <= settings.tolerance {
                break;
            }
        }
    }
    outcome
}
