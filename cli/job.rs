//! Checked jobs: what the arguments of each command come to. Files are found, combinations refused and defaults resolved here, before
//! work starts; the commands read their jobs and nothing else.

mod bench;
mod check;
mod film;
mod frames;
mod images;
mod inspect;
mod movie;
mod output;
mod plot;
mod render;
mod rib;
mod run;
mod run_folder;
mod schema;
mod shader;
mod simulate;
mod solve;
mod stitch;
pub mod sweep;

pub use crate::args::SchemaKind;
pub use bench::{BenchJob, RenderBench, SimBench};
pub use check::{CheckJob, FileKind};
pub use film::{FilmJob, PlanJob, StatusJob, TaskJob, combination, images_of};
pub use frames::{FramesJob, Origin};
pub use images::{ImageJob, ImageOptions};
pub use inspect::{InspectJob, Suggestion};
pub use movie::{MovieFile, MovieJob, MovieKind};
pub use plot::{Curve, Plot, PlotJob};
pub use render::{RenderFrames, RenderJob, RenderScene, Statistics};
pub use rib::RibJob;
pub use run::RunJob;
pub use schema::SchemaJob;
pub use shader::{ShaderFile, ShaderJob};
pub use simulate::{ModelRun, SimulateJob};
pub use solve::SolveJob;
pub use stitch::StitchJob;
pub use sweep::{Plan, Sweep, SweepJob};
