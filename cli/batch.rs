//! Work laid out in tasks: the plan of a film, the scripts that schedulers run its tasks by, and the schedulers.

mod plan;
mod queue;
mod script;

pub use plan::{ImageChoices, Plan, Requests, Scheduler, Simulation, Task};
pub use queue::{most_indices, state_of, submit, submitted};
pub use script::{Job, jobs};
