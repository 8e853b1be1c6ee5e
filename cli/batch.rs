//! Work laid out in tasks: the plan of a film, the scripts that schedulers run its tasks by, and the schedulers.

mod made_of;
pub mod marks;
mod movie;
mod plan;
mod queue;
mod script;

pub use made_of::MadeOf;
pub use movie::{Movie, MovieStanding, images as movie_images};
pub use plan::{ImageChoices, Plan, Requests, Scheduler, Simulation, Task};
pub use queue::{Slurm, most_indices, slurm, state_of, submit, submitted};
pub use script::{Job, Needed, jobs};
