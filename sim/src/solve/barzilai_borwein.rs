//! Spectral projected gradients (Barzilai & Borwein 1988; Birgin, Martínez & Raydan 2000): the step length is the inverse of a
//! Rayleigh quotient of N along the last move, in the metric of η; the search along the projected direction is exact, since
//! the objective is quadratic.

use super::*;

pub fn run(
    op: &mut impl Operator,
    limit: Limit,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    const LOOK: u32 = 10;
    let n = gamma.len();
    work.next.resize(n, DVec3::ZERO);
    let mut alpha = 1.0;
    let mut best = Outcome { iterations: 0, residual: f64::INFINITY };
    let mut best_is_current = false;
    let mut done = 0;
    while done < limit.iterations {
        done += 1;
        let (now, x, im) = (&*op, &*gamma, &*image);
        // next = the projected point; d = next − γ.
        let [slope, length2] = sweep(&mut work.next, |first, rows| {
            let mut sums = [0.0; 2];
            for (k, z) in rows.iter_mut().enumerate() {
                let i = first + k;
                let (gradient, eta) = (now.pull(im, i), now.eta(i));
                *z = now.project(i, x[i] - gradient * (alpha * eta), x);
                let d = *z - x[i];
                sums[0] += gradient.dot(d);
                sums[1] += d.length_squared() / eta;
            }
            sums
        });
        if !(length2 > 0.0) {
            best = Outcome { iterations: done, residual: residual(op, gamma, image) };
            best_is_current = true;
            break;
        }
        op.image(&work.next, &mut work.image_next);
        let curvature = op.curvature(&work.image_next, image);
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
        if done.is_multiple_of(LOOK) || done >= limit.iterations {
            let residual = residual(op, gamma, image);
            best_is_current = residual <= best.residual;
            if best_is_current {
                best = Outcome { iterations: done, residual };
                if residual <= limit.tolerance {
                    break;
                }
                if done < limit.iterations {
                    work.best.clear();
                    work.best.extend_from_slice(gamma);
                    work.image_best.copy_from(image);
                }
            }
        }
    }
    if !best_is_current {
        gamma.copy_from_slice(&work.best);
        image.copy_from(&work.image_best);
    }
    Outcome { iterations: done, residual: best.residual }
}
