//! The solver of the CPU back end: cone complementarity problems and the methods that solve them.
//!
//! A problem is a symmetric operator N, an offset r and a product of cones: minimise `½ γᵀNγ + rᵀγ` over γ in the cones
//! (Negrut et al. 2012, §2). A method ([`crate::Method`]) sees N only as an [`Operator`]: `bodies` and `body_operator` apply it
//! matrix-free to contacts between bodies, with the joints eliminated; `crate::problem` has one of sparse blocks.
//!
//! A block has three multipliers. Those of a contact are a vector in the world frame, so that no tangent frame is needed.

mod apgd;
mod barzilai_borwein;
pub mod bodies;
mod body_operator;
pub mod cells;
pub mod cone;
mod descend;
pub mod exact;
mod gauss_seidel;
mod group;
mod islands;
pub mod iterates;
pub mod jacobi;
pub mod joints;
pub mod limits;
pub mod lorentz;
mod manifold_group;
mod method;
pub mod motors;
pub mod operator;
pub mod overlaps;
mod packed;
pub mod pivoting;
pub mod residual;
mod resistance;
pub mod response;
mod scale;
pub mod schedule;
pub mod slip;
mod sparse;
mod sphere_group;
pub mod support;
pub mod sweeps;
mod visit;

use crate::outcome::Outcome;
use crate::rows::CHUNK;
use crate::settings::{FrictionLaw, Method, SolverSettings};
use cells::Cells;
use glam::DVec3;
use iterates::Iterates;
use operator::Operator;
use rayon::prelude::*;
use response::Response;

/// Solve: γ comes in as the starting point and goes out as the solution, `response` as its response.
pub fn solve(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    if op.n_blocks() == 0 {
        op.response(gamma, response);
        return Outcome::default();
    }
    if op.has_independent_cones() {
        let values = Cells::new(gamma);
        // SAFETY: each index is one task's, and no cone depends on another block's multipliers.
        let project = |i: usize| unsafe { values.set(i, op.project_in(i, values.get(i), &values)) };
        (0..op.n_blocks()).into_par_iter().with_min_len(CHUNK).for_each(project);
    } else {
        // In order: the cone of a rolling block depends on its contact's multipliers.
        (0..gamma.len()).for_each(|i| gamma[i] = op.project(i, gamma[i], gamma));
    }
    op.response(gamma, response);
    if settings.friction == FrictionLaw::Exact {
        if settings.method != Some(Method::Jacobi) {
            return exact::run(op, settings, gamma, response, work);
        }
        slip::set_feedback(op, settings, gamma, response);
    }
    scale::scale(op, settings.max_iterations(gamma.len()), gamma, response, work);
    method::run(op, settings, gamma, response, work)
}
