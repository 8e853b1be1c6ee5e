//! `scree solve`: a friction problem from a file, solved to a tolerance; its error, iterations and time.

use crate::job::SolveJob;
use crate::report::{Exit, Failure, Outcome};
use glam::DVec3;
use serde_json::json;
use sim::problem::{self, MatrixOperator};
use std::time::Instant;

/// Run `scree solve`.
pub fn run(job: SolveJob) -> Outcome {
    let SolveJob { path, mut problem, law, multipliers, json } = job;
    let started = Instant::now();
    let solution = problem::solve(&mut problem, &law);
    let seconds = started.elapsed().as_secs_f64();
    let converged = solution.error <= law.tolerance;
    if let Some(file) = multipliers {
        frame::atomic::write(&file, table(&problem, &solution.gamma).as_bytes())?;
    }
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

/// The multipliers and relative velocities of the contacts, as CSV with a row per contact: normal, tangent, tangent, of both.
fn table(problem: &MatrixOperator, gamma: &[DVec3]) -> String {
    let mut table = String::from("contact,gamma_n,gamma_t,gamma_s,u_n,u_t,u_s\n");
    for (i, own) in gamma.iter().enumerate() {
        let numbers = [own.to_array(), problem.velocity(gamma, i).to_array()].concat();
        let row: Vec<String> = numbers.iter().map(|x| format!("{x:e}")).collect();
        table += &format!("{i},{}\n", row.join(","));
    }
    table
}
