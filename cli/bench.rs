//! `scree bench`: the workloads that engines and renderers are compared on, with fixed JSON keys.

use crate::args::{Backend, BenchArgs, BenchCommand};
use crate::library;
use crate::report::{Exit, Failure, Outcome, peak_bytes};
use render::Context;
use render::ri::{Class, Fail, InstanceShape, Instances, Param, Ri, Type};
use serde_json::json;
use sim::stages::Stage;
use sim::workload::{self, Workload};
use sim::{FrictionLaw, Method, Simulation, SolverSettings, SplitMix64};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The command.
pub fn command(args: &BenchArgs) -> Outcome {
    let backend = match &args.what {
        BenchCommand::Sim { backend, .. } | BenchCommand::Render { backend, .. } => *backend,
    };
    if backend == Backend::Gpu {
        return Err(Failure::new(Exit::Usage, "--backend gpu: there is no GPU back end yet; use cpu"));
    }
    match &args.what {
        BenchCommand::Sim { workload, n, steps, step, iterations, method, friction, recovery_speed, json, .. } => {
            let workload = match workload.to_lowercase().as_str() {
                "s" => Workload::S,
                "a" => Workload::A,
                other => return Err(Failure::new(Exit::Usage, format!("--workload {other}: expected s or a"))),
            };
            let method = crate::solve::method_of(method)?;
            if *n == 0 || !(*step > 0.0) {
                return Err(Failure::new(Exit::Usage, "--n and --step: expected numbers above 0"));
            }
            let friction = match friction {
                Some(name) => crate::solve::law_of(name)?,
                None if method == Method::GaussSeidel => FrictionLaw::Exact,
                None => FrictionLaw::Relaxed,
            };
            let solver =
                SolverSettings { recovery_speed: *recovery_speed, friction, ..workload::solver(method, *iterations) };
            print(bench_sim(workload, *n, *steps, *step, solver), *json);
            Ok(())
        }
        BenchCommand::Render { n, motion, f_stop, shading_rate, res, image, json, .. } => {
            let bed =
                Bed { n: (*n).max(1), motion: *motion, f_stop: *f_stop, shading_rate: *shading_rate, resolution: *res };
            print(bench_render(&bed, image.as_ref())?, *json);
            Ok(())
        }
    }
}

fn print(result: serde_json::Value, as_json: bool) {
    if as_json {
        println!("{result}");
    } else if let Some(map) = result.as_object() {
        for (key, value) in map {
            println!("{key:44} {value}");
        }
    }
}

fn bench_sim(workload: Workload, n: usize, steps: Option<u64>, step: f64, solver: SolverSettings) -> serde_json::Value {
    let (cpu, wall) = (cpu_seconds(), Instant::now());
    let (model, state) = workload::build(workload, n, solver.clone(), step);
    let mut sim = Simulation::new(model, state);
    let steps = steps.unwrap_or((1.0 / step).round() as u64);
    let (mut contact_iterations, mut contacts) = (0.0, 0);
    let mut stage_ms = [0.0; Stage::ALL.len()];
    for _ in 0..steps {
        let r = sim.step();
        contact_iterations += r.contacts as f64 * r.iterations as f64;
        stage_ms.iter_mut().zip(r.stage_ms).for_each(|(sum, ms)| *sum += ms);
        contacts = r.contacts;
    }
    let of = |stages: &[&str]| {
        let wanted = Stage::ALL.into_iter().zip(stage_ms).filter(|(stage, _)| stages.contains(&stage.name()));
        wanted.map(|(_, ms)| ms).sum::<f64>()
    };
    let all_ms: f64 = stage_ms.iter().sum();
    let solver_ms = of(&["contact_solve"]);
    let detection_ms = of(&["bounds", "bin_emit", "bin_sort", "bin_start", "pair_write", "contact_write"]);
    let cores = rayon::current_num_threads() as f64;
    let stages: serde_json::Map<String, serde_json::Value> = Stage::ALL
        .iter()
        .zip(stage_ms)
        .map(|(stage, ms)| (stage.name().to_string(), json!(ms / steps as f64)))
        .collect();
    let radius = sim.model.shape_size.iter().map(|s| s.x).fold(0.0, f64::max);
    json!({
        "workload": format!("{workload:?}"), "n": n, "backend": "cpu", "threads": rayon::current_num_threads(),
        "step": step, "steps": steps, "iterations": solver.iterations, "method": solver.method, "friction": solver.friction,
        "recovery_speed": solver.recovery_speed,
        "cpu_seconds_per_simulated_second": (cpu_seconds() - cpu) / (steps as f64 * step),
        "wall_seconds": wall.elapsed().as_secs_f64(),
        "worst_penetration_over_r": sim.state.contacts.worst_penetration() / radius,
        "kinetic_energy_j": sim.state.kinetic_energy(&sim.model),
        "contacts": contacts,
        "contact_iterations_per_second_per_core": contact_iterations / (solver_ms * 1e-3 * cores),
        "shapes_per_second_per_core": (n as u64 * steps) as f64 / (detection_ms * 1e-3 * cores),
        "other_share_of_step": 1.0 - (solver_ms + detection_ms) / all_ms,
        "stage_ms": stages,
        "solver_share_of_step": solver_ms / all_ms,
        "peak_bytes": peak_bytes(),
        "max_position_difference_m": serde_json::Value::Null,
    })
}

/// A bed of spheres to draw, and how.
struct Bed {
    n: usize,
    motion: bool,
    f_stop: Option<f32>,
    shading_rate: f32,
    resolution: [u32; 2],
}

fn bench_render(bed: &Bed, image: Option<&PathBuf>) -> Outcome<serde_json::Value> {
    let (cpu, wall) = (cpu_seconds(), Instant::now());
    let fault = |f: Fail| Failure::new(Exit::Fault, f.message);
    let mut context = Context::new(library::files(Path::new("."))).map_err(fault)?;
    draw_bed(&mut context, bed).map_err(fault)?;
    let finished = context.results.pop().ok_or_else(|| Failure::new(Exit::Fault, "no picture was made"))?;
    let displays: Vec<_> = finished.options.displays.iter().collect();
    let bytes =
        finished.image.encode(&displays, &finished.options.encoding()).map_err(|m| Failure::new(Exit::Fault, m))?;
    if let Some(path) = image {
        frame::atomic::write(path, &bytes)?;
    }
    let s = finished.stats;
    Ok(json!({
        "n": bed.n, "backend": "cpu", "threads": rayon::current_num_threads(), "resolution": bed.resolution,
        "motion": bed.motion, "f_stop": bed.f_stop, "shading_rate": bed.shading_rate,
        "cpu_seconds": cpu_seconds() - cpu, "wall_seconds": wall.elapsed().as_secs_f64(),
        "micropolygons": s.micropolygons, "samples": s.samples, "shaded_points": s.shaded_points,
        "grids": s.grids, "grids_hidden": s.grids_hidden, "seconds": s.seconds, "peak_bytes": peak_bytes(),
    }))
}

/// G(n): twelve layers of spheres of 0.075 m with some jitter and a gentle swell, a colour each, seen at 30° from above, one
/// distant light with shadows, on a grey ground. The same bed as the peers' scenes but for the jitter's random numbers.
fn draw_bed(ri: &mut impl Ri, bed: &Bed) -> Result<(), Fail> {
    const R: f64 = 0.075;
    let n = bed.n;
    let per = n.div_ceil(12);
    let d = 2.0 * R;
    let h = (per as f64 * d * d * 3f64.sqrt() / 2.0 / 7.614).sqrt();
    let nx = (3.24 * h / d).round().max(1.0) as usize;
    let (dy, dz) = (d * 3f64.sqrt() / 2.0, d * (2.0f64 / 3.0).sqrt());
    let mut random = SplitMix64(12345);
    let (mut position, mut color) = (Vec::new(), Vec::new());
    for i in 0..n {
        let (layer, k) = (i / per, i % per);
        let (ix, iy) = (k % nx, k / nx);
        let mut p = [
            (ix as f64 + 0.5 * ((iy + layer) % 2) as f64) * d - 0.5 * nx as f64 * d,
            iy as f64 * dy + (layer % 2) as f64 * dy / 3.0 * 2.0 + 0.95 * h,
            R + layer as f64 * dz,
        ];
        p.iter_mut().for_each(|x| *x += random.between(-0.12 * R, 0.12 * R));
        p[2] = p[2].max(R);
        let swell = ((p[0] * 2.1 / h * 3.0).sin() * (p[1] * 1.7 / h * 3.0).cos() + 1.0) * 0.5;
        p[2] += 2.0 * R * (p[2] / (12.0 * dz)) * swell;
        position.push(p.map(|x| x as f32));
        color.extend([0, 1, 2].map(|_| random.between(0.15, 1.0) as f32));
    }
    let number = |name: &str, x: f32| Param::floats(name, Class::Uniform, Type::Float, [x]);
    // A bell of numbers with the deviation 0.35 R, as the sum of twelve even ones less six has it.
    let mut step = || (0.35 * R * ((0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0)) as f32;
    let moved = bed.motion.then(|| ([0.0, 1.0], position.iter().map(|p: &[f32; 3]| p.map(|x| x + step())).collect()));
    let [width, height] = bed.resolution.map(|n| n as i32);
    ri.format(width, height, 1.0)?;
    ri.display("bed.png", "png", "rgb", vec![])?;
    ri.shutter(0.0, 1.0)?;
    if let Some(f_stop) = bed.f_stop {
        // The ray through the middle meets the bed at twice the height of the eye.
        ri.depth_of_field(f_stop, 0.05 * h as f32, 2.0 * h as f32)?;
    }
    ri.pixel_samples(4.0, 4.0)?;
    ri.pixel_filter("box", 1.0, 1.0)?;
    ri.exposure(1.0, 2.2)?;
    ri.projection("perspective", vec![number("fov", 30.0)])?;
    ri.clipping(0.05, 20.0 * h as f32)?;
    let (s, c) = 30f64.to_radians().sin_cos();
    let (right, up, forward) = ([1.0, 0.0, 0.0], [0.0, s, c], [0.0, c, -s]);
    let eye = [0.0, 0.0, 11.0 * dz + 2.0 * R + h];
    let dot = |a: [f64; 3]| -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    let axes = [right, up, forward];
    let mut matrix = [0.0f32; 16];
    for row in 0..3 {
        for column in 0..3 {
            matrix[4 * row + column] = axes[column][row] as f32;
        }
        matrix[12 + row] = dot(axes[row]) as f32;
    }
    matrix[15] = 1.0;
    ri.concat_transform(matrix)?;
    ri.world_begin()?;
    ri.shading_rate(bed.shading_rate)?;
    let way = Param::floats("to", Class::Uniform, Type::Point, [0.5, 0.4, -0.8]);
    let from = Param::floats("from", Class::Uniform, Type::Point, [0.0; 3]);
    ri.light_source("distantlight", "sun", vec![number("intensity", 1.0), from, way])?;
    ri.surface("matte", vec![number("Ka", 0.0), number("Kd", 1.0)])?;
    ri.attribute_begin()?;
    ri.color([0.5; 3])?;
    let [x, y0, y1] = [8.0 * h, 0.5 * h, 12.0 * h].map(|x| x as f32);
    ri.polygon(vec![Param::floats(
        "P",
        Class::Vertex,
        Type::Point,
        [-x, y0, 0.0, x, y0, 0.0, x, y1, 0.0, -x, y1, 0.0],
    )])?;
    ri.attribute_end()?;
    ri.instances(Instances {
        moved,
        shape: InstanceShape::Sphere,
        scale: vec![[R as f32; 3]; position.len()],
        position,
        orientation: vec![],
        params: vec![Param::floats("Cs", Class::Uniform, Type::Color, color)],
    })?;
    ri.world_end()
}

/// User and system seconds of this process so far (Linux; 0 elsewhere).
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
