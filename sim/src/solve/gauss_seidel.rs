//! Gauss–Seidel: block after block sees what the blocks before it did. Blocks of one colour share no body, so that they run
//! side by side and the result does not hang on the number of threads. The joints are one block of their own, solved exactly
//! at the end of each sweep.

use super::lanes::LANES;
use super::*;
use rayon::prelude::*;

/// Blocks of a colour that one task visits.
const TASK: usize = 1024;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    let omega = settings.omega.unwrap_or(1.0);
    let n = gamma.len();
    op.colors(&mut work.color_start, &mut work.color_order);
    let mut packed = std::mem::take(&mut work.packed);
    let (start, order) = (&work.color_start[..], &work.color_order[..]);
    let fast = op.pack(start, order, gamma, &mut packed);
    let mut outcome = Outcome::default();
    for iteration in 1..=settings.iterations {
        let twist = Cells::new(&mut image.twist);
        let missed: f64 = if fast {
            packed
                .colors()
                .map(|color| share(color.par_chunks_mut(TASK / LANES), |g| balls::visit(g, &twist, omega)))
                .sum()
        } else {
            let (values, now) = (Cells::new(gamma), &*op);
            let visit = |blocks: &[u32]| visit::visit(now, blocks, &twist, &values, omega);
            let colors = start.windows(2).map(|ends| &order[ends[0] as usize..ends[1] as usize]);
            colors.map(|color| share(color.par_chunks(TASK), visit)).sum()
        };
        op.settle(image);
        // How far each block was off when it was visited, in the residual's units.
        outcome = Outcome { iterations: iteration, residual: missed.sqrt() / n as f64 };
        if outcome.residual <= settings.tolerance {
            break;
        }
    }
    if fast {
        packed.unpack(start, order, gamma);
    }
    work.packed = packed;
    outcome
}

/// Visit the tasks of a colour, side by side if there are enough to be worth it; sums in order.
fn share<T: Send>(tasks: impl IndexedParallelIterator<Item = T>, visit: impl Fn(T) -> f64 + Send + Sync) -> f64 {
    /// Up to so many are done by one thread.
    const FEW: usize = 4;
    let least = if tasks.len() <= FEW { FEW } else { 1 };
    let parts: Vec<f64> = tasks.with_min_len(least).map(visit).collect();
    parts.into_iter().sum()
}
