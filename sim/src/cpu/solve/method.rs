//! Dispatch to the methods.

use super::iterates::Iterates;
use super::operator::Operator;
use super::residual::is_idle;
use super::response::Response;
use super::{apgd, barzilai_borwein, gauss_seidel, jacobi};
use crate::outcome::Outcome;
use crate::settings::{Method, SolverSettings};
use glam::DVec3;

/// Solve the convex problem with the current offset by the method of the settings.
pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    if is_idle(op, gamma, response) {
        return Outcome::default();
    }
    match settings.method.unwrap_or(Method::Apgd) {
        Method::Jacobi => jacobi::run(op, settings, gamma, response, work),
        Method::GaussSeidel => gauss_seidel::run(op, settings, gamma, response, work),
        Method::Apgd => apgd::run(op, settings, gamma, response, work),
        Method::BarzilaiBorwein => barzilai_borwein::run(op, settings, gamma, response, work),
    }
}
