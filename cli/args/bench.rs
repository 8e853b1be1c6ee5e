//! Arguments of `scree bench`.

use super::simulate::{Friction, Method, Quality};
use super::value::{Backend, Resolution, index, number, positive, resolution, size, whole};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Arguments of `scree bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    pub bench: BenchCommand,
}

/// The benchmarks.
#[derive(Subcommand, Debug)]
pub enum BenchCommand {
    /// Simulate spheres that settle in a box, convex bodies, or joints.
    Sim(BenchSimArgs),
    /// Render a bed of spheres with shadows, 16 samples per pixel.
    Render(BenchRenderArgs),
    /// Run the kernels of a graphics adapter.
    Gpu(BenchGpuArgs),
}

const SIM_EXAMPLES: &str = "\
Example:
  scree bench sim --n 1000 --method apgd --iterations 50 --json";

/// Arguments of `scree bench sim`.
#[derive(Args, Debug)]
#[command(after_help = SIM_EXAMPLES)]
pub struct BenchSimArgs {
    /// What is simulated.
    #[arg(long, default_value = "s", ignore_case = true)]
    pub workload: Workload,
    /// Number of spheres or boxes, of boxes in the lowest row of the pyramid, of
    /// layers of the pile, of joints along an edge of the grid [default: 8000,
    /// 5000, 100, 80, 100].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=u64::MAX))]
    pub n: Option<usize>,
    /// Level of quality, which chooses the step and the solver where they are not
    /// given [default: normal for other workloads than spheres].
    #[arg(long)]
    pub quality: Option<Quality>,
    /// Back end to compute with.
    #[arg(long, default_value = "cpu")]
    pub backend: Backend,
    /// Number of steps [default: those of one simulated second; of 5 s of the
    /// pyramid, 1.5 s of the pile, 2 s of the boxes and the grid].
    #[arg(long, value_name = "N", value_parser = index::<u64>())]
    pub steps: Option<u64>,
    /// Step size, s [default: 1.5e-3, or that of the quality].
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub step: Option<f64>,
    /// Solver iterations in each step [default: 24, or those of the quality;
    /// gauss_seidel: 8, and more where spheres overlap].
    #[arg(long, value_name = "N", value_parser = index::<u32>())]
    pub iterations: Option<u32>,
    /// Solver [default: gauss_seidel, or that of the quality].
    #[arg(long)]
    pub method: Option<Method>,
    /// Law of friction [default: exact for gauss_seidel, which solves it
    /// contact by contact; relaxed for the other solvers].
    #[arg(long)]
    pub friction: Option<Friction>,
    /// Maximum speed at which overlapping bodies are pushed apart, m/s [default:
    /// 0.03, or that of the quality].
    #[arg(long, value_name = "SPEED", value_parser = number::<f64>)]
    pub recovery_speed: Option<f64>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

const RENDER_EXAMPLES: &str = "\
Example:
  scree bench render --n 10000 --motion --f-stop 4 --json";

/// Arguments of `scree bench render`.
#[derive(Args, Debug)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct BenchRenderArgs {
    /// Number of spheres.
    #[arg(long, default_value_t = 84_000, value_name = "N", value_parser = index::<usize>())]
    pub n: usize,
    /// Back end to draw with.
    #[arg(long, default_value = "cpu")]
    pub backend: Backend,
    /// Graphics adapter of --backend gpu, by its index in `scree doctor` or by a
    /// part of its name [default: the first that is no software adapter].
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    /// The most memory that the image takes of the graphics adapter, as 2GiB, at
    /// least 64MiB [default: what it needs].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub gpu_memory: Option<u64>,
    /// Draw the same with this back end, too, and compare samples and pixels.
    #[arg(long, value_name = "BACKEND")]
    pub compare: Option<Comparison>,
    /// Move the spheres while the shutter is open, by about a third of their
    /// radius.
    #[arg(long)]
    pub motion: bool,
    /// Add light from the sky, hidden by what is in its way.
    #[arg(long)]
    pub sky: bool,
    /// f-stop of the lens, as 4, focused on the middle of the image
    /// [default: a pinhole, all in focus].
    #[arg(long, value_name = "F", value_parser = number::<f32>)]
    pub f_stop: Option<f32>,
    /// Shading rate: area of a micropolygon, pixels.
    #[arg(long, default_value = "1", value_name = "AREA", value_parser = number::<f32>)]
    pub shading_rate: f32,
    /// Width and height, pixels.
    #[arg(long, value_name = "WxH", value_parser = resolution, default_value = "1280x720")]
    pub res: Resolution,
    /// Number of times that the image is drawn, as the frames of a film are; the
    /// figures are those of the last.
    #[arg(long, default_value_t = 1, value_name = "K", value_parser = index::<usize>())]
    pub frames: usize,
    /// Write the image to this file (PNG).
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

const GPU_EXAMPLES: &str = "\
Example:
  scree bench gpu --adapter 0 --small --json";

/// Arguments of `scree bench gpu`.
#[derive(Args, Debug)]
#[command(after_help = GPU_EXAMPLES)]
pub struct BenchGpuArgs {
    /// Graphics adapter, by its index in `scree doctor` or by a part of its
    /// name [default: the first that is no software adapter].
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    /// Run small sizes, for software adapters.
    #[arg(long)]
    pub small: bool,
    /// Time for all of it, s: what is expected to take longer is left out.
    #[arg(long, default_value_t = 460, value_name = "SECONDS", value_parser = whole::<u64>(1..=86_400))]
    pub seconds: u64,
    /// File of the JSON so far, written whole after each row.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Back ends to compare with.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Comparison {
    /// The processor.
    Cpu,
}

/// Workloads.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Workload {
    /// Spheres of radius 0.075 m.
    S,
    /// Spheres of radius 0.025 to 0.036 m, as in the bed of the anchor model.
    A,
    /// Boxes that stand on each other.
    Pyramid,
    /// Hulls of 32 points that fall upon each other.
    Pile,
    /// Boxes poured into a box.
    Boxes,
    /// A net of spherical joints.
    Grid,
}
