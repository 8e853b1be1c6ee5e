//! The command line as clap parses it: commands, flags and the syntax of their values. What files and flags mean together is
//! checked in `job`.

mod author;
mod batch;
mod bench;
mod data;
mod image;
mod simulate;
mod value;

pub use author::{
    CheckArgs, CompletionsArgs, DoctorArgs, InitArgs, ManArgs, SchemaArgs, SchemaKind, ShaderArgs, StarterArg,
};
pub use batch::{CutArgs, PlanArgs, ResumeArgs, SchedulerArg, StatusArgs, SubmitArgs, TaskArgs, VerifyArgs};
pub use bench::{BenchArgs, BenchCommand, BenchGpuArgs, BenchRenderArgs, BenchSimArgs, Comparison, Workload};
pub use data::{ExportArgs, FormatArg, InspectArgs, PlotArgs, PreviewArgs, ReportArgs};
pub use image::{ImageArgs, MovieArgs, QualityChoice, RenderArgs, RibArgs, StitchArgs};
pub use simulate::{Friction, Method, Quality, RunArgs, SimulateArgs, SolveArgs};
pub use value::{Assignment, Axis, Backend, Interval, ShardArg};

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use value::{size, whole};

const EXIT_CODES: &str = "\
Exit codes:
    0  the command did all of its work
    1  fault of the program or of the machine
    2  wrong command line
    3  bad input file: model, metadata, RIB scene or shader
    4  bad or missing data, or a simulation that diverged
    5  work partly done, or a simulation that ended with warnings
  130  interrupted";

/// Simulate granular material and vehicles, and render the runs to images and movies.
///
/// A model (YAML) describes bodies, materials and joints; a metadata file (YAML) describes how data is rendered. Start with a
/// project of your own: `scree init demo`, whose README says how to go on. Units are SI: m, kg, s.
#[derive(Parser, Debug)]
#[command(name = "scree", version, after_help = EXIT_CODES)]
pub struct Args {
    /// Threads to use, 1 to 1024 [default: one for each processor].
    #[arg(long, global = true, value_name = "N", value_parser = whole::<u16>(1..=1024), display_order = 900)]
    pub threads: Option<u16>,
    /// Memory that reading and rendering may take, as 8GiB or 500MiB
    /// [default: half of this machine's; for simulations all of it].
    #[arg(long, global = true, value_name = "SIZE", value_parser = size, display_order = 901)]
    pub memory: Option<u64>,
    /// Read no files outside of this folder, whatever scenes, metadata and
    /// models name.
    #[arg(long, global = true, value_name = "DIR", display_order = 902)]
    pub root: Option<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

/// The commands, in the order of the help: from a model to a movie first, then data, authoring, other renderers and measuring.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Lay a small project into a folder: a model, metadata, a shader.
    Init(InitArgs),
    /// Simulate, render and encode a movie from a model or a metadata file.
    ///
    /// A model is rendered with the metadata.yaml that its simulation writes. A metadata file is rendered from its `data`, or
    /// from the run of its `model`. A model is not simulated again if its finished run exists.
    Run(RunArgs),
    /// Simulate a model into a run directory.
    ///
    /// The run directory holds frames/ (positions, velocities and sizes of all shapes), probes.csv, report.csv (contacts,
    /// iterations and residuals of every step), checkpoints/, run.json, and metadata.yaml to render the run with.
    Simulate(SimulateArgs),
    /// Render frames of a run or of a metadata file, or a RIB scene.
    ///
    /// The image of frame 12 is 000012.png, or .exr if the metadata says so. The images of a RIB scene have the names of its
    /// Display requests.
    Render(RenderArgs),
    /// Say which tasks a film has and how long they take; make nothing.
    Plan(PlanArgs),
    /// Make a film by tasks: by Slurm, PBS or Grid Engine, or here.
    ///
    /// The model is simulated if its run is not there, the images that are missing or stale are drawn by arrays of tasks, and a last
    /// task checks all of them and makes the movie. Tasks may be killed and run again at any time.
    Submit(SubmitArgs),
    /// Say how far a film, or a folder of images, is.
    Status(StatusArgs),
    /// Check that every image is whole and up to date.
    ///
    /// What is truncated, edited, missing or stale is named, with exit code 5.
    Verify(VerifyArgs),
    /// Submit the tasks of a film again that are not done.
    Resume(ResumeArgs),
    /// Run one task of a film, as job scripts do.
    #[command(hide = true)]
    Task(TaskArgs),
    /// Encode a folder of images as a movie.
    Movie(MovieArgs),
    /// Plot the probes of a run over time, as PNG and SVG.
    Plot(PlotArgs),
    /// Look at a run or any data in the Rerun viewer, or in a browser.
    ///
    /// A run is followed while it is simulated. The viewer's bridge is a program of its own, scree-preview, that is built apart: see
    /// docs/preview.md.
    Preview(PreviewArgs),
    /// Make a page of a run, or of the runs of a sweep, as one HTML file.
    ///
    /// The page has the film, images, plots to zoom into, warnings, the energy balance, how well the contacts were solved, and what
    /// the run was made of.
    Report(ReportArgs),
    /// Show frames, columns and ranges of data; write metadata for it.
    Inspect(InspectArgs),
    /// Write frames as files of ParaView, pandas, OVITO and others.
    Export(ExportArgs),
    /// Check models, metadata, scenes and shaders without running them.
    ///
    /// An error names file, line and column. All files are checked; the exit code is the highest of theirs.
    Check(CheckArgs),
    /// Print the JSON Schema of models or of metadata, for editors.
    ///
    /// Editors complete the keys of a file by its schema, and mark what is wrong.
    Schema(SchemaArgs),
    /// Check shaders; print their parameters with types and defaults.
    Shader(ShaderArgs),
    /// Print a frame as RIB, for any RenderMan renderer.
    Rib(RibArgs),
    /// Join the shards of `scree render --bucket` to whole images.
    ///
    /// The images are, bit for bit, those of a single render.
    Stitch(StitchArgs),
    /// Solve a friction problem from a file; print its error and time.
    Solve(SolveArgs),
    /// Measure the speed of simulation or rendering on this machine.
    Bench(BenchArgs),
    /// List what of this machine scree can use, and how fast it writes.
    Doctor(DoctorArgs),
    /// Print what a shell needs to complete commands and flags.
    Completions(CompletionsArgs),
    /// Write the pages of the manual, for `man`.
    Man(ManArgs),
}

impl Command {
    /// Whether it may simulate.
    pub fn simulates(&self) -> bool {
        match self {
            Command::Bench(args) => !matches!(args.bench, BenchCommand::Render(_)),
            command => matches!(command, Command::Run(_) | Command::Simulate(_) | Command::Task(_) | Command::Solve(_)),
        }
    }
}
