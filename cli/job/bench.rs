//! The job of `scree bench`.

use super::render::DrawOn;
use super::simulate::cpu_only;
use crate::args::{self, BenchArgs, BenchCommand, BenchGpuArgs, BenchRenderArgs, BenchSimArgs};
use crate::machine;
use crate::report::Outcome;
use sim::workload::{self, Convex, Workload};
use sim::{FrictionLaw, Method, Quality, Simulation, SolverSettings};
use std::path::PathBuf;
use std::time::Duration;

/// A benchmark to run.
pub enum BenchJob {
    /// A simulation, and whether its result is printed as JSON.
    Sim(Box<SimBench>, bool),
    /// A rendering, and whether its result is printed as JSON.
    Render(RenderBench, bool),
    /// Kernels of a graphics adapter, and whether its result is printed as JSON.
    Gpu(GpuBench, bool),
}

/// A benchmark of the simulation.
pub struct SimBench {
    /// Name of the workload.
    pub workload: String,
    /// Number of what the workload counts.
    pub n: usize,
    /// Number of steps.
    pub steps: u64,
    /// Level of quality, if one chooses the settings.
    pub quality: Option<Quality>,
    /// The simulation, which holds the step and the settings of the solver.
    pub simulation: Simulation,
    /// CPU time of the process before the simulation was made, s.
    pub cpu_before: f64,
}

/// A benchmark of the renderer: a bed of spheres.
pub struct RenderBench {
    /// Number of spheres.
    pub n: usize,
    /// Whether the spheres move while the shutter is open.
    pub motion: bool,
    /// Whether there is light from the sky.
    pub sky: bool,
    /// The lens; a pinhole without.
    pub f_stop: Option<f32>,
    /// Area of a micropolygon, pixels.
    pub shading_rate: f32,
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    /// Number of times that it is drawn.
    pub frames: usize,
    /// The file of the image, if it is kept.
    pub image: Option<PathBuf>,
    /// What draws.
    pub on: DrawOn,
    /// The most memory that is taken of a graphics adapter, bytes, if there is a limit.
    pub gpu_memory: Option<u64>,
    /// Whether the processor draws the same, too, for a comparison.
    pub compares: bool,
}

/// A benchmark of a graphics adapter.
pub struct GpuBench {
    /// The adapter.
    pub adapter: gpu::Choice,
    /// Whether sizes are small.
    pub small: bool,
    /// Time for all of it.
    pub time: Duration,
    /// The file of the result so far.
    pub out: Option<PathBuf>,
}

impl BenchJob {
    /// Check the arguments.
    pub fn check(args: BenchArgs) -> Outcome<BenchJob> {
        match args.bench {
            BenchCommand::Sim(args) => Ok(BenchJob::Sim(Box::new(sim_bench(&args)?), args.json)),
            BenchCommand::Render(args) => {
                let json = args.json;
                Ok(BenchJob::Render(render_bench(args)?, json))
            }
            BenchCommand::Gpu(BenchGpuArgs { adapter, small, seconds, out, json }) => {
                let adapter = adapter.map_or(gpu::Choice::Hardware, gpu::Choice::Named);
                let time = Duration::from_secs(seconds);
                Ok(BenchJob::Gpu(GpuBench { adapter, small, time, out }, json))
            }
        }
    }
}

fn sim_bench(args: &BenchSimArgs) -> Outcome<SimBench> {
    cpu_only(args.backend)?;
    let cpu_before = machine::cpu_seconds();
    let convex = match args.workload {
        args::Workload::S => return spheres(args, Workload::S, cpu_before),
        args::Workload::A => return spheres(args, Workload::A, cpu_before),
        args::Workload::Pyramid => Convex::Pyramid,
        args::Workload::Pile => Convex::Pile,
        args::Workload::Boxes => Convex::Boxes,
        args::Workload::Grid => Convex::Grid,
    };
    let (n, seconds) = convex.size();
    let n = args.n.unwrap_or(n);
    let quality = args.quality.map_or(Quality::Normal, Quality::from);
    let mut model = workload::scene(convex, n);
    model.file.quality = Some(quality);
    let mut simulation = model.into_simulation()?;
    settle(args, &mut simulation.model.solver);
    simulation.model.step = args.step.unwrap_or(simulation.model.step);
    let steps = args.steps.unwrap_or((seconds / simulation.model.step).round() as u64);
    let workload = format!("{convex:?}").to_lowercase();
    Ok(SimBench { workload, n, steps, quality: Some(quality), simulation, cpu_before })
}

/// A benchmark of spheres.
fn spheres(args: &BenchSimArgs, workload: Workload, cpu_before: f64) -> Outcome<SimBench> {
    let n = args.n.unwrap_or(8000);
    let quality = args.quality.map(Quality::from);
    let solver = SolverSettings { recovery_speed: 0.03, ..workload::solver(Method::GaussSeidel, 24) };
    let sweeps_more = args.iterations.is_none() && matches!(args.method, None | Some(args::Method::GaussSeidel));
    let solver = if sweeps_more { workload::sweeping_more(workload, solver) } else { solver };
    let (mut model, state) = workload::build(workload, n, solver, args.step.unwrap_or(1.5e-3));
    if let Some(quality) = quality {
        let (step, solver) = quality.settings(&model, &state, None);
        model.step = args.step.unwrap_or(step);
        model.solver = SolverSettings { envelope: model.solver.envelope, ..solver };
    }
    settle(args, &mut model.solver);
    if quality.is_none() && args.friction.is_none() && model.solver.method == Some(Method::GaussSeidel) {
        model.solver.friction = FrictionLaw::Exact;
    }
    let steps = args.steps.unwrap_or((1.0 / model.step).round() as u64);
    let simulation = Simulation::new(model, state);
    Ok(SimBench { workload: format!("{workload:?}"), n, steps, quality, simulation, cpu_before })
}

/// Take the settings of the command line.
fn settle(args: &BenchSimArgs, solver: &mut SolverSettings) {
    if let Some(method) = args.method {
        solver.method = Some(method.into());
        solver.omega = None;
    }
    if let Some(friction) = args.friction {
        solver.friction = friction.into();
    }
    solver.iterations = args.iterations.or(solver.iterations);
    solver.recovery_speed = args.recovery_speed.unwrap_or(solver.recovery_speed);
}

fn render_bench(args: BenchRenderArgs) -> Outcome<RenderBench> {
    let on = DrawOn::check(args.backend, args.adapter)?;
    let gpu_memory = on.memory(args.gpu_memory)?;
    let BenchRenderArgs { n, motion, sky, f_stop, shading_rate, res, frames, image, compare, .. } = args;
    let compares = matches!(compare, Some(args::Comparison::Cpu));
    let (n, frames) = (n.max(1), frames.max(1));
    Ok(RenderBench { n, motion, sky, f_stop, shading_rate, resolution: res, frames, image, on, gpu_memory, compares })
}
