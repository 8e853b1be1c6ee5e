//! Gauss–Seidel: block after block sees what the blocks before it did. Blocks of one colour share no body, so that they run
//! side by side and the result does not hang on the number of threads. The joints are one block of their own, solved exactly
//! at the end of each sweep.

use super::*;
use rayon::prelude::*;

/// Blocks of a colour that one task visits.
const TASK: usize = 1024;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    limit: Limit,
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
    for iteration in 1..=limit.iterations {
        let twist = Cells::new(&mut image.twist);
        let missed: f64 = if fast {
            packed.colors().map(|color| share(color, TASK / 4, |groups| balls::visit(groups, &twist, omega))).sum()
        } else {
            let (values, now) = (Cells::new(gamma), &*op);
            let colors = start.windows(2).map(|ends| ends[0] as usize..ends[1] as usize);
            colors
                .map(|color| {
                    let mut blocks = order[color].to_vec();
                    share(&mut blocks, TASK, |blocks| visit::visit(now, blocks, &twist, &values, omega))
                })
                .sum()
        };
        op.settle(image);
        // How far each block was off when it was visited, in the residual's units.
        outcome = Outcome { iterations: iteration, residual: missed.sqrt() / n as f64 };
        if outcome.residual <= limit.tolerance {
            break;
        }
    }
    if fast {
        packed.unpack(start, order, gamma);
    }
    work.packed = packed;
    outcome
}

/// Visit what a colour has in tasks of a fixed size, side by side if it is worth it; sums in order.
fn share<T: Send>(color: &mut [T], task: usize, visit: impl Fn(&mut [T]) -> f64 + Send + Sync) -> f64 {
    if color.len() <= 4 * task {
        return color.chunks_mut(task).map(visit).sum();
    }
    let parts: Vec<f64> = color.par_chunks_mut(task).map(visit).collect();
    parts.into_iter().sum()
}
