//! Projected Gauss–Seidel: each block is solved with the impulses of the blocks before it. Blocks of one colour have no body in common,
//! so that they run in parallel and the result does not depend on the number of threads. The joints are one block, solved exactly at
//! the end of each sweep. Contacts that know friction alone have faster sweeps (`sweeps`).

use super::cells::Cells;
use super::iterates::Iterates;
use super::operator::Operator;
use super::response::Response;
use super::visit;
use crate::outcome::Outcome;
use crate::rows::{add, reduce_tasks};
use crate::settings::SolverSettings;
use glam::DVec3;
use rayon::prelude::*;

/// Number of blocks of a task.
const TASK: usize = 1024;
/// Number of blocks of a colour up to which one thread visits them.
const SERIAL_LIMIT: usize = 4 * TASK;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    op.colors(&mut work.colored);
    let omega = settings.omega.unwrap_or(1.0);
    let n = gamma.len();
    let mut outcome = Outcome::default();
    for iteration in 1..=settings.max_iterations(n) {
        let twist = Cells::new(&mut response.twist);
        let (values, now) = (Cells::new(gamma), &*op);
        // SAFETY: blocks of a colour have no moving body in common, each is one task's, and a rolling block, which reads its contact's
        // multipliers, has that contact's bodies.
        let visit = |blocks: &[u32]| [unsafe { visit::visit(now, blocks, &twist, &values, omega) }];
        let visit_color = |color: &[u32]| reduce_tasks(color.par_chunks(TASK), color.len() <= SERIAL_LIMIT, visit);
        let [residual2] = work.colored.colors().map(visit_color).fold([0.0], add);
        op.solve_joints(response);
        outcome = Outcome { iterations: iteration, residual: residual2.sqrt() / n as f64 };
        if outcome.residual <= settings.tolerance {
            break;
        }
    }
    outcome
}
