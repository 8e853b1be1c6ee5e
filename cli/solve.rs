//! `scree solve`: a friction problem from a file, solved as far as asked, and how well.
//!
//! The file: number of dimensions (3), number of contacts, then W either as sparse blocks (`1`) or dense by columns (`0`), q with
//! three numbers a contact (normal, tangent, tangent), and the coefficient of friction of each contact.

use crate::args::SolveArgs;
use crate::report::{Exit, Failure, Outcome};
use serde_json::json;
use sim::problem::{self, Law};
use sim::{FrictionLaw, Method};
use std::time::Instant;

/// The law of friction of a name.
pub fn law_of(name: &str) -> Outcome<FrictionLaw> {
    match name {
        "exact" => Ok(FrictionLaw::Exact),
        "relaxed" => Ok(FrictionLaw::Relaxed),
        other => Err(Failure::new(Exit::Usage, format!("--friction {other}: expected exact or relaxed"))),
    }
}

/// The command.
pub fn command(args: &SolveArgs) -> Outcome {
    let friction = law_of(&args.friction)?;
    let method = match &args.method {
        None => None,
        Some(name) => Some(method_of(name)?),
    };
    if !(args.tolerance > 0.0) || args.iterations == 0 {
        return Err(Failure::new(Exit::Usage, "--tolerance and --iterations: expected numbers above 0"));
    }
    let mut problem = problem::read(&args.file)?;
    let started = Instant::now();
    let law = Law { friction, tolerance: args.tolerance, iterations: args.iterations, method };
    let solution = problem::solve(&mut problem, &law);
    let seconds = started.elapsed().as_secs_f64();
    let converged = solution.error <= args.tolerance;
    if args.json {
        let result = json!({
            "file": args.file.display().to_string(), "contacts": problem.q.len(), "friction": args.friction,
            "method": solution.method, "error": solution.error, "iterations": solution.iterations,
            "seconds": seconds, "converged": converged,
        });
        println!("{result}");
    } else {
        println!(
            "{}: {} contacts, error {:.3e} after {} iterations of {} in {seconds:.3} s",
            args.file.display(),
            problem.q.len(),
            solution.error,
            solution.iterations,
            solution.method
        );
    }
    if converged {
        return Ok(());
    }
    let message =
        format!("the error is {:.3e}, not below {:.1e}: allow more --iterations", solution.error, args.tolerance);
    Err(Failure::new(Exit::Partial, message))
}

/// A method by its name.
pub fn method_of(name: &str) -> Outcome<Method> {
    Method::ALL.into_iter().find(|m| m.name() == name).ok_or_else(|| {
        let names: Vec<&str> = Method::ALL.iter().map(|m| m.name()).collect();
        Failure::new(Exit::Usage, format!("method {name}: expected one of {}", names.join(", ")))
    })
}
