//! Accelerated projected gradient descent (Mazhar, Heyn, Negrut, Tasora 2015): Nesterov's sequence with adaptive restart and
//! back-tracking on the step length. One product with N an iteration: the image of the extrapolated point is the same
//! combination of images as the point is of points.
//!
//! The step length t goes on from solve to solve, within bounds. In the metric of η the trace of N is 3 n_blocks, so that
//! t = 1/(3 n_blocks) is short enough for any move. A move so small that its curvature is lost in the rounding of the images, as
//! where contacts carry nothing or the solution is met, says nothing of N: t stays. Moves along which N nearly vanishes do not
//! lengthen it beyond [`LONGEST`].

use super::*;

/// The longest step. Directions in which N is so small are those of contacts whose bodies are held by joints.
const LONGEST: f64 = 1e6;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    let mut best = Best::new();
    work.previous.clone_from(gamma);
    work.next.resize(gamma.len(), DVec3::ZERO);
    work.image_y.copy_from(image);
    let (mut theta, mut beta) = (1.0f64, 0.0);
    // Velocities are sums of impulses that cancel where bodies rest: both sizes count.
    let [impulses] = sum_rows(gamma.len(), |i| [gamma[i].length_squared() / op.eta(i)]);
    let rounding = (op.energy(image) + impulses) * (ROUNDING * ROUNDING);
    let shortest = 1.0 / (3.0 * gamma.len() as f64);
    let is_sound = (shortest..=LONGEST).contains(&work.step_length);
    let mut step = if is_sound { work.step_length } else { 1.0 };
    let mut done = 0;
    let most = settings.most_iterations(gamma.len());
    while done < most {
        loop {
            done += 1;
            let from = Extrapolated { x: gamma, previous: &work.previous, beta, image: &work.image_y };
            let [moved, slope] = op.descend(&mut work.next, &from, step, &mut work.image_next);
            // Restart where the gradient and the move disagree.
            let uphill = slope > 0.0;
            let next_theta = 0.5 * (theta * (theta * theta + 4.0).sqrt() - theta * theta);
            let next_beta = if uphill { 0.0 } else { theta * (1.0 - theta) / (theta * theta + next_theta) };
            let images = [&mut work.image_next, &mut work.image_y_next];
            let curvature = op.advance(&work.next, next_beta, [image, &work.image_y], images);
            let is_known = curvature > rounding;
            // The step is short enough if ½ dᵀNd ≤ |d|²/(2 t) in the metric of η; d is from y.
            if !is_known || curvature * step <= moved * (1.0 + 1e-9) || step <= shortest || done >= most {
                beta = next_beta;
                theta = if uphill { 1.0 } else { next_theta };
                work.step_length = step;
                if is_known {
                    step = (1.1 * step).min(LONGEST);
                }
                break;
            }
            step = (0.95 * moved / curvature).min(0.95 * step).max(shortest);
        }
        // previous ← γ ← next, and their images.
        std::mem::swap(&mut work.previous, gamma);
        std::mem::swap(gamma, &mut work.next);
        std::mem::swap(image, &mut work.image_next);
        std::mem::swap(&mut work.image_y, &mut work.image_y_next);
        if best.look(op, settings, done, (gamma, image), (&mut work.best, &mut work.image_best)) {
            break;
        }
    }
    best.finish(done, gamma, image, work)
}
