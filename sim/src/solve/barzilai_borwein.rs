//! Spectral projected gradients (Barzilai & Borwein 1988; Birgin, Martínez & Raydan 2000): the step length is the inverse of a
//! Rayleigh quotient of N along the last move, in the metric of η; the search along the projected direction is exact, since
//! the objective is quadratic.

use super::*;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    let mut best = Best::new();
    work.next.resize(gamma.len(), DVec3::ZERO);
    let mut alpha = 1.0;
    let mut done = 0;
    while done < settings.most_iterations(gamma.len()) {
        done += 1;
        // next = the projected point; d = next − γ.
        let from = Extrapolated { x: gamma, previous: gamma, beta: 0.0, image };
        let [length2, slope] = op.descend(&mut work.next, &from, alpha, &mut work.image_next);
        if !(length2 > 0.0) {
            // Every block is where its projection leaves it.
            best.compare(Outcome { iterations: done, residual: residual(op, gamma, image) });
            break;
        }
        let images = [&mut work.image_next, &mut work.image_y];
        let curvature = op.advance(&work.next, 0.0, [image, image], images);
        // Spectral steps are not monotone; a full step is taken unless the objective rises along it.
        let along = if curvature > 0.0 && slope < 0.0 { (-slope / curvature).min(1.0) } else { 1.0 };
        alpha = if curvature > 0.0 { (length2 / curvature).clamp(1e-4, 1e4) } else { 1e4 };
        if along < 1.0 {
            gamma.iter_mut().zip(&work.next).for_each(|(x, z)| *x += (*z - *x) * along);
            work.image_y.extrapolate(image, &work.image_next, -along);
            std::mem::swap(image, &mut work.image_y);
        } else {
            gamma.copy_from_slice(&work.next);
            std::mem::swap(image, &mut work.image_next);
        }
        if best.look(op, settings, done, (gamma, image), (&mut work.best, &mut work.image_best)) {
            break;
        }
    }
    best.finish(done, gamma, image, work)
}
