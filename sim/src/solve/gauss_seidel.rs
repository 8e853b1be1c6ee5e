//! Gauss–Seidel: block after block sees what the blocks before it did. Blocks of one colour share no body, so that they run
//! side by side and the result does not hang on the number of threads. The joints are one block of their own, solved exactly
//! at the end of each sweep. Contacts between balls alone have sweeps of their own (`balls`).

use super::*;

/// Blocks of a colour that one task visits.
const TASK: usize = 1024;
/// Blocks of a colour that are not worth a second thread.
const LITTLE: usize = 4 * TASK;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    op.colors(&mut work.colored);
    let omega = settings.omega.unwrap_or(1.0);
    let n = gamma.len();
    let mut outcome = Outcome::default();
    for iteration in 1..=settings.most_iterations(n) {
        let twist = Cells::new(&mut image.twist);
        let (values, now) = (Cells::new(gamma), &*op);
        let visit = |blocks: &[u32]| [visit::visit(now, blocks, &twist, &values, omega)];
        let visit_color = |color: &[u32]| share(color.par_chunks(TASK), color.len() <= LITTLE, visit);
        let [missed] = work.colored.colors().map(visit_color).fold([0.0], add);
        op.settle(image);
        outcome = Outcome { iterations: iteration, residual: missed.sqrt() / n as f64 };
        if outcome.residual <= settings.tolerance {
            break;
        }
    }
    outcome
}
