//! Arguments of the commands that simulate: `run`, `simulate` and `solve`.

use super::image::{ImageArgs, RedrawArgs};
use super::value::{Assignment, Backend, assignment, index, positive, whole};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const RUN_EXAMPLES: &str = "\
Examples:
  scree run metadata.yaml
  scree run model.yaml -o runs/pour --res 640x360 --samples 2";

/// Arguments of `scree run`.
#[derive(Args, Debug)]
#[command(after_help = RUN_EXAMPLES)]
pub struct RunArgs {
    /// Model or metadata file (YAML).
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// Folder of the run, its images and the movie [default: runs/NAME for
    /// NAME.yaml].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Simulate again, and replace the run that the folder holds, be it of this
    /// model or another.
    #[arg(long)]
    pub fresh: bool,
    /// Back end to simulate and to draw with, each as `scree simulate` and
    /// `scree render` have it.
    #[arg(long, default_value = "auto")]
    pub backend: Backend,
    /// Graphics adapter of --backend gpu, by its index in `scree doctor` or by a
    /// part of its name [default: the first that is no software adapter].
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    #[command(flatten)]
    pub image: ImageArgs,
    #[command(flatten)]
    pub redraw: RedrawArgs,
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  scree simulate model.yaml -o runs/pour --until 0.5
  scree simulate model.yaml -o runs/pour --resume
  scree simulate model.yaml --set solver.method=gauss_seidel";

/// Arguments of `scree simulate`.
#[derive(Args, Debug)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub struct SimulateArgs {
    /// Model file (YAML).
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Run directory; of a model with a `sweep`, the folder of its runs
    /// [default: runs/NAME for NAME.yaml].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Simulate up to this time, s [default: the model's `duration`].
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Continue from the last checkpoint of the run directory; the model's
    /// duration may be longer than before.
    #[arg(long, conflicts_with = "fresh")]
    pub resume: bool,
    /// Replace the run that the run directory holds, be it of another model.
    #[arg(long)]
    pub fresh: bool,
    /// Level of quality, which chooses the step and the solver's settings that
    /// the model does not give.
    #[arg(long)]
    pub quality: Option<Quality>,
    /// Replace a value of the model, as --set solver.iterations=80 or --set
    /// bodies.block.mass=3; may be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub set: Vec<Assignment>,
    /// Simulate only the combination with this index, from 0 (models with a
    /// `sweep`) [default: all of them].
    #[arg(long, value_name = "INDEX", value_parser = index::<usize>(), conflicts_with = "plan", allow_negative_numbers = true)]
    pub sweep_index: Option<usize>,
    /// Print the combinations, but simulate nothing (models with a `sweep`).
    #[arg(long)]
    pub plan: bool,
    /// Back end to compute with.
    #[arg(long, default_value = "auto")]
    pub backend: Backend,
    /// Graphics adapter of --backend gpu, by its index in `scree doctor` or by a
    /// part of its name [default: the first that is no software adapter].
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    /// First stage of the step that the graphics adapter runs; those before it
    /// are the processor's, to tell in which of them a fault is.
    #[arg(long, value_name = "STAGE", value_parser = PossibleValuesParser::new(sim::stages::Stage::ALL.map(|stage| stage.name())))]
    pub gpu_from: Option<String>,
    /// Write frames as CSV instead of Arrow files.
    #[arg(long)]
    pub csv: bool,
    /// Show the run in the Rerun viewer while it is simulated.
    #[arg(long, conflicts_with = "plan")]
    pub preview: bool,
}

const SOLVE_EXAMPLES: &str = "\
The problem is u = W r + q with Coulomb's cones for the impulses r. Its file has
numbers separated by white space: dimensions (3), contacts n, kind of matrix (0
dense, 1 blocks), W, q (normal, tangent, tangent for each contact) and n
coefficients of friction.

Exit code 5 means that the error is still above the tolerance.

Example:
  scree solve tests/data/friction/uncoupled_dense.dat --tolerance 1e-6";

/// Arguments of `scree solve`.
#[derive(Args, Debug)]
#[command(after_help = SOLVE_EXAMPLES)]
pub struct SolveArgs {
    /// Friction problem (.dat).
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Law of friction.
    #[arg(long, default_value = "exact")]
    pub friction: Friction,
    /// Stop when the relative error, |F_nat| / |q|, is at most this; as 1e-6.
    #[arg(long, default_value = "1e-4", value_name = "ERROR", value_parser = positive)]
    pub tolerance: f64,
    /// Maximum of iterations (sweeps of gauss_seidel and jacobi).
    #[arg(long, default_value_t = 1_000_000, value_name = "N", value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub iterations: u32,
    /// Solver [default: gauss_seidel and apgd in turns].
    #[arg(long)]
    pub method: Option<Method>,
    /// Write the multipliers and relative velocities of the contacts to this CSV file.
    #[arg(long, value_name = "FILE")]
    pub multipliers: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Levels of quality of a simulation.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Quality {
    /// To see what happens.
    Draft,
    /// For films and most numbers.
    Normal,
    /// For forces.
    Tight,
}

/// Laws of friction.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Friction {
    /// Coulomb's law.
    Exact,
    /// Convex relaxation: sliding contacts separate at μ times their speed.
    Relaxed,
}

/// Solvers of the friction problem.
#[derive(ValueEnum, Clone, Copy, Debug)]
#[value(rename_all = "snake_case")]
pub enum Method {
    /// Accelerated projected gradient descent.
    Apgd,
    /// Spectral projected gradient.
    BarzilaiBorwein,
    /// Projected Gauss-Seidel sweeps, contact by contact.
    GaussSeidel,
    /// Projected Jacobi sweeps.
    Jacobi,
}
