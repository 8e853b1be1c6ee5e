//! Gauss–Seidel: block after block sees what the blocks before it did. Blocks of one colour share no body, so that they run
//! side by side and the result does not hang on the number of threads. The joints are one block of their own, solved exactly
//! at the end of each sweep.
//!
//! Contacts between balls have a visit of their own (`balls`), first in single precision, and in double once what they miss is
//! near its rounding; Coulomb's law itself costs these no outer loop. The bodies' velocities are made anew from the impulses after it, so that no rounding of it is left in the
//! momentum.

use super::*;
use rayon::prelude::*;

/// Blocks of a colour that one task visits.
const TASK: usize = 1024;
/// Where single precision ends: contacts miss by so many times the greatest speed, root mean square.
const COARSE: f64 = 1e-5;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    op.colors(&mut work.color_start, &mut work.color_order);
    if !op.has_balls_only() {
        return any(op, settings, gamma, image, work);
    }
    let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY };
    if image.lambda.is_empty() {
        let fastest = image.twist.iter().fold(0.0f64, |most, t| most.max(t.v.length_squared())).sqrt();
        let enough = COARSE * fastest * (gamma.len() as f64).sqrt() / gamma.len() as f64;
        let mut packed = std::mem::take(&mut work.coarse);
        balls(op, settings, gamma, image, (&work.color_start, &work.color_order), &mut packed, enough, &mut outcome);
        work.coarse = packed;
        op.image(gamma, image);
    }
    if outcome.iterations < settings.iterations && outcome.residual > settings.tolerance {
        let mut packed = std::mem::take(&mut work.fine);
        balls(op, settings, gamma, image, (&work.color_start, &work.color_order), &mut packed, 0.0, &mut outcome);
        work.fine = packed;
    }
    outcome
}

/// Sweeps over contacts between balls until they are good enough.
#[allow(clippy::too_many_arguments)]
fn balls<T: balls::Grouped<L>, const L: usize>(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    (start, order): (&[u32], &[u32]),
    packed: &mut balls::Packed<T, L>,
    enough: f64,
    outcome: &mut Outcome,
) {
    let omega = settings.omega.unwrap_or(1.0);
    op.pack(start, order, gamma, image, packed);
    while outcome.iterations < settings.iterations {
        // How far each block was off when it was visited, in the residual's units.
        let missed = packed.sweep(settings.friction, omega);
        *outcome = Outcome { iterations: outcome.iterations + 1, residual: missed.sqrt() / gamma.len() as f64 };
        if !image.lambda.is_empty() {
            packed.store(image);
            op.settle(image);
            packed.load(image);
        }
        if outcome.residual <= settings.tolerance.max(enough) {
            break;
        }
    }
    packed.unpack(start, order, gamma);
    packed.store(image);
}

/// Sweeps over blocks of any kind.
fn any(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &Workspace,
) -> Outcome {
    let omega = settings.omega.unwrap_or(1.0);
    let n = gamma.len();
    let mut outcome = Outcome::default();
    for iteration in 1..=settings.iterations {
        let twist = Cells::new(&mut image.twist);
        let (values, now) = (Cells::new(gamma), &*op);
        let visit = |blocks: &[u32]| visit::visit(now, blocks, &twist, &values, omega);
        let colors = work.color_start.windows(2).map(|ends| &work.color_order[ends[0] as usize..ends[1] as usize]);
        let missed: f64 = colors.map(|color| share(color.par_chunks(TASK), visit)).sum();
        op.settle(image);
        outcome = Outcome { iterations: iteration, residual: missed.sqrt() / n as f64 };
        if outcome.residual <= settings.tolerance {
            break;
        }
    }
    outcome
}
