//! The job of `scree bench`.

use super::simulate::cpu_only;
use crate::args::{self, BenchArgs, BenchCommand, BenchGpuArgs, BenchRenderArgs, BenchSimArgs};
use crate::report::Outcome;
use sim::workload::{self, Workload};
use sim::{FrictionLaw, Method, SolverSettings};
use std::path::PathBuf;

/// A benchmark to run.
pub enum BenchJob {
    /// A simulation, and whether its result is printed as JSON.
    Sim(SimBench, bool),
    /// A rendering, and whether its result is printed as JSON.
    Render(RenderBench, bool),
    /// Kernels of a graphics adapter, and whether its result is printed as JSON.
    Gpu(GpuBench, bool),
}

/// A benchmark of the simulation.
pub struct SimBench {
    /// Workload of spheres.
    pub workload: Workload,
    /// Number of spheres.
    pub n: usize,
    /// Number of steps.
    pub steps: u64,
    /// Step size, s.
    pub step: f64,
    /// Settings of the solver.
    pub solver: SolverSettings,
}

/// A benchmark of the renderer: a bed of spheres.
pub struct RenderBench {
    /// Number of spheres.
    pub n: usize,
    /// Whether the spheres move while the shutter is open.
    pub motion: bool,
    /// The lens; a pinhole without.
    pub f_stop: Option<f32>,
    /// Area of a micropolygon, pixels.
    pub shading_rate: f32,
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    /// The file of the image, if it is kept.
    pub image: Option<PathBuf>,
}

/// A benchmark of a graphics adapter.
pub struct GpuBench {
    /// The adapter.
    pub adapter: gpu::Choice,
    /// Whether sizes are small.
    pub small: bool,
}

impl BenchJob {
    /// Check the arguments.
    pub fn check(args: BenchArgs) -> Outcome<BenchJob> {
        match args.bench {
            BenchCommand::Sim(args) => Ok(BenchJob::Sim(sim_bench(&args)?, args.json)),
            BenchCommand::Render(args) => {
                let json = args.json;
                Ok(BenchJob::Render(render_bench(args)?, json))
            }
            BenchCommand::Gpu(BenchGpuArgs { adapter, small, json }) => {
                let adapter = adapter.map_or(gpu::Choice::Hardware, gpu::Choice::Named);
                Ok(BenchJob::Gpu(GpuBench { adapter, small }, json))
            }
        }
    }
}

fn sim_bench(args: &BenchSimArgs) -> Outcome<SimBench> {
    cpu_only(args.backend)?;
    let workload = match args.workload {
        args::Workload::S => Workload::S,
        args::Workload::A => Workload::A,
    };
    let method = Method::from(args.method);
    let friction = match args.friction {
        Some(friction) => friction.into(),
        None if method == Method::GaussSeidel => FrictionLaw::Exact,
        None => FrictionLaw::Relaxed,
    };
    let solver =
        SolverSettings { recovery_speed: args.recovery_speed, friction, ..workload::solver(method, args.iterations) };
    let steps = args.steps.unwrap_or((1.0 / args.step).round() as u64);
    Ok(SimBench { workload, n: args.n, steps, step: args.step, solver })
}

fn render_bench(args: BenchRenderArgs) -> Outcome<RenderBench> {
    cpu_only(args.backend)?;
    let BenchRenderArgs { n, motion, f_stop, shading_rate, res, image, .. } = args;
    Ok(RenderBench { n: n.max(1), motion, f_stop, shading_rate, resolution: res, image })
}
