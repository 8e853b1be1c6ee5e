//! `scree solve`: a friction problem from a file, solved to a tolerance; its error, iterations and time.

use crate::job::SolveJob;
use crate::report::{Exit, Failure, Outcome};
use serde_json::json;
use sim::problem;
use std::time::Instant;

/// Run `scree solve`.
pub fn run(job: SolveJob) -> Outcome {
    let SolveJob { path, mut problem, law, json } = job;
    let started = Instant::now();
    let solution = problem::solve(&mut problem, &law);
    let seconds = started.elapsed().as_secs_f64();
    let converged = solution.error <= law.tolerance;
    if json {
        let result = json!({
            "file": path.display().to_string(), "contacts": problem.q.len(), "friction": law.friction,
            "method": solution.method, "error": solution.error, "iterations": solution.iterations,
            "seconds": seconds, "converged": converged,
        });
        println!("{result}");
    } else {
        println!(
            "{}: {} contacts, error {:.3e} after {} iteration{} of {} in {seconds:.3} s",
            path.display(),
            problem.q.len(),
            solution.error,
            solution.iterations,
            if solution.iterations == 1 { "" } else { "s" },
            solution.method
        );
    }
    if converged {
        return Ok(());
    }
    let message = format!(
        "not converged: the error is {:.3e}, above the tolerance of {:.1e}; allow more --iterations",
        solution.error, law.tolerance
    );
    Err(Failure::new(Exit::Partial, message))
}
