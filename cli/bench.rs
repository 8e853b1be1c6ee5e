//! `scree bench`: the workloads that engines and renderers are compared on, with fixed JSON keys.

mod gpu;
mod render;
mod sim;

use crate::job::BenchJob;
use crate::report::{Exit, Failure, Outcome};

/// Run `scree bench`.
pub fn run(job: BenchJob) -> Outcome {
    match job {
        BenchJob::Sim(job, json) => print(&sim::measure(*job), json),
        BenchJob::Render(job, json) => print(&render::measure(&job)?, json),
        BenchJob::Gpu(job, json) => {
            let (result, is_whole) = gpu::measure(&job)?;
            print(&result, json);
            if !is_whole {
                return Err(Failure::new(Exit::Interrupted, "interrupted: the result says what is left out"));
            }
        }
    }
    Ok(())
}

/// Print the result: JSON, or a line for each key.
fn print(result: &serde_json::Value, json: bool) {
    if json {
        println!("{result}");
    } else if let Some(map) = result.as_object() {
        for (key, value) in map {
            println!("{key:44} {value}");
        }
    }
}
