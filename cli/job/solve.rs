//! The job of `scree solve`.

use crate::args::{self, SolveArgs};
use crate::report::Outcome;
use sim::problem::MatrixOperator;
use sim::problem::{self, Law};
use sim::{FrictionLaw, Method};
use std::path::PathBuf;

/// A friction problem to solve.
pub struct SolveJob {
    /// The problem's file.
    pub path: PathBuf,
    /// The problem.
    pub problem: MatrixOperator,
    /// The law of friction, the tolerance and the solver.
    pub law: Law,
    /// File for the multipliers.
    pub multipliers: Option<PathBuf>,
    /// Whether JSON is printed.
    pub json: bool,
}

impl SolveJob {
    /// Check the arguments: read the problem.
    pub fn check(args: SolveArgs) -> Outcome<SolveJob> {
        let law = Law {
            friction: args.friction.into(),
            tolerance: args.tolerance,
            iterations: args.iterations,
            method: args.method.map(Method::from),
        };
        let problem = problem::read(&args.file)?;
        Ok(SolveJob { problem, path: args.file, law, multipliers: args.multipliers, json: args.json })
    }
}

impl From<args::Friction> for FrictionLaw {
    fn from(friction: args::Friction) -> FrictionLaw {
        match friction {
            args::Friction::Exact => FrictionLaw::Exact,
            args::Friction::Relaxed => FrictionLaw::Relaxed,
        }
    }
}

impl From<args::Method> for Method {
    fn from(method: args::Method) -> Method {
        match method {
            args::Method::Apgd => Method::Apgd,
            args::Method::BarzilaiBorwein => Method::BarzilaiBorwein,
            args::Method::GaussSeidel => Method::GaussSeidel,
            args::Method::Jacobi => Method::Jacobi,
        }
    }
}
