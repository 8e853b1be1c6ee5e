//! `scree bench render`: a bed of spheres in twelve layers, one distant light with shadows, on a grey ground.
//!
//! It is the bed of the peers' scenes but for the random numbers of its jitter.

use crate::device::Drawer;
use crate::job::RenderBench;
use crate::library;
use crate::machine::{cpu_seconds, peak_bytes};
use crate::report::{Exit, Failure, Outcome};
use render::ri::{Class, Fail, InstanceShape, Instances, Param, Ri, Type};
use render::{Context, DeviceRenderer, DrawnBy, RenderResult};
use serde_json::json;
use sim::SplitMix64;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Render the bed and measure it.
pub fn measure(job: &RenderBench) -> Outcome<serde_json::Value> {
    let device = Drawer::new(job.on.clone()).within(job.gpu_memory).device()?;
    let (mut frames, mut last) = (vec![], None);
    for k in 0..job.frames {
        let (cpu, wall) = (cpu_seconds(), Instant::now());
        let result = draw(job, device.clone())?;
        if let DrawnBy::Fallback(why) = &result.drawn_by {
            return Err(Failure::new(Exit::Usage, format!("--backend gpu: {why}")));
        }
        let drawn = wall.elapsed().as_secs_f64();
        let bytes = encode(&result)?;
        if let Some(path) = job.image.as_ref().filter(|_| k + 1 == job.frames) {
            frame::atomic::write(path, &bytes)?;
        }
        let (cpu, wall) = (cpu_seconds() - cpu, wall.elapsed().as_secs_f64());
        let s = result.stats;
        frames.push(json!({
            "cpu_seconds": cpu, "wall_seconds": wall, "encode_seconds": wall - drawn, "seconds": s.seconds, "device": s.device,
        }));
        last = Some((result, cpu, wall));
    }
    let Some((result, cpu, wall)) = last else { return Err(Failure::new(Exit::Usage, "no frames")) };
    let is_gpu = result.drawn_by == DrawnBy::Gpu;
    let s = result.stats;
    let mut report = json!({
        "n": job.n, "backend": if is_gpu { "gpu" } else { "cpu" }, "threads": rayon::current_num_threads(), "resolution": job.resolution,
        "motion": job.motion, "sky": job.sky, "f_stop": job.f_stop, "shading_rate": job.shading_rate,
        "cpu_seconds": cpu, "wall_seconds": wall,
        "micropolygons": s.micropolygons, "shaded_points": s.shaded_points,
        "grids": s.grids, "grids_hidden": s.grids_hidden, "seconds": s.seconds, "peak_bytes": peak_bytes(),
    });
    match device.filter(|_| is_gpu) {
        Some(device) => {
            report["adapter"] = device.adapter().name.clone().into();
            report["is_software"] = device.adapter().software.into();
            report["device"] = json!(s.device);
        }
        // Devices do not count their tests.
        None => report["samples"] = s.samples.into(),
    }
    if job.frames > 1 {
        report["frames"] = frames.into();
    }
    if job.compares {
        let other = draw(job, None)?;
        report["ids_equal_fraction"] =
            fraction_of(result.identities.iter().zip(&other.identities).map(|(a, b)| a == b)).into();
        let pixels = |result: &RenderResult| encode(result).and_then(|bytes| bytes_of_pixels(&bytes));
        let (own, others) = (pixels(&result)?, pixels(&other)?);
        let near = |(a, b): (&[u8], &[u8])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 2);
        report["pixels_within_2_fraction"] = fraction_of(own.chunks(3).zip(others.chunks(3)).map(near)).into();
    }
    Ok(report)
}

/// Draw the bed.
fn draw(job: &RenderBench, device: Option<Arc<DeviceRenderer>>) -> Outcome<RenderResult> {
    let fault = |f: Fail| Failure::new(Exit::Fault, f.message);
    let mut context = Context::new(library::files(Path::new("."))).map_err(fault)?;
    (context.device, context.keep_ids) = (device, job.compares);
    request_bed(&mut context, job).map_err(fault)?;
    context.results.pop().ok_or_else(|| Failure::new(Exit::Fault, "no image was rendered"))
}

fn encode(result: &RenderResult) -> Outcome<Vec<u8>> {
    let displays: Vec<_> = result.options.displays.iter().collect();
    result.image.encode(&displays, &result.options.encoding()).map_err(|m| Failure::new(Exit::Fault, m))
}

/// The numbers of a PNG image, 8 bits each.
fn bytes_of_pixels(png: &[u8]) -> Outcome<Vec<u8>> {
    let image = image::load_from_memory(png).map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
    Ok(image.into_rgb8().into_raw())
}

/// The part of some answers that hold.
fn fraction_of(answers: impl Iterator<Item = bool>) -> f64 {
    let (n, held) = answers.fold((0u64, 0u64), |(n, held), holds| (n + 1, held + holds as u64));
    held as f64 / n.max(1) as f64
}

/// Radius of the spheres, m.
const RADIUS: f64 = 0.075;
/// Number of layers.
const LAYERS: usize = 12;

/// The spheres of a bed.
struct Bed {
    /// Centres when the shutter opens, m.
    position: Vec<[f32; 3]>,
    /// Centres when it closes, m, if they move.
    moved: Option<Vec<[f32; 3]>>,
    /// Colours, three values each.
    color: Vec<f32>,
    /// Height of the camera above the bed, which the lengths of the scene are multiples of, m.
    height: f64,
    /// Distance of two layers, m.
    layer: f64,
}

impl Bed {
    /// Lay out the spheres on a hexagonal lattice with some jitter and a gentle swell.
    fn new(n: usize, motion: bool) -> Bed {
        const R: f64 = RADIUS;
        let per_layer = n.div_ceil(LAYERS);
        let d = 2.0 * R;
        let h = (per_layer as f64 * d * d * 3f64.sqrt() / 2.0 / 7.614).sqrt();
        let nx = (3.24 * h / d).round().max(1.0) as usize;
        let (dy, dz) = (d * 3f64.sqrt() / 2.0, d * (2.0f64 / 3.0).sqrt());
        let mut random = SplitMix64(12345);
        let (mut position, mut color) = (Vec::new(), Vec::new());
        for i in 0..n {
            let (layer, k) = (i / per_layer, i % per_layer);
            let (ix, iy) = (k % nx, k / nx);
            let mut p = [
                (ix as f64 + 0.5 * ((iy + layer) % 2) as f64) * d - 0.5 * nx as f64 * d,
                iy as f64 * dy + (layer % 2) as f64 * dy / 3.0 * 2.0 + 0.95 * h,
                R + layer as f64 * dz,
            ];
            p.iter_mut().for_each(|x| *x += random.between(-0.12 * R, 0.12 * R));
            p[2] = p[2].max(R);
            let swell = ((p[0] * 2.1 / h * 3.0).sin() * (p[1] * 1.7 / h * 3.0).cos() + 1.0) * 0.5;
            p[2] += 2.0 * R * (p[2] / (LAYERS as f64 * dz)) * swell;
            position.push(p.map(|x| x as f32));
            color.extend([0, 1, 2].map(|_| random.between(0.15, 1.0) as f32));
        }
        // Normal deviates with the deviation 0.35 R: the sum of twelve uniform ones less six.
        let mut step = || (0.35 * R * ((0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0)) as f32;
        let moved = motion.then(|| position.iter().map(|p: &[f32; 3]| p.map(|x| x + step())).collect());
        Bed { position, moved, color, height: h, layer: dz }
    }
}

fn float(name: &str, x: f32) -> Param {
    Param::floats(name, Class::Uniform, Type::Float, [x])
}

fn point(name: &str, p: [f32; 3]) -> Param {
    Param::floats(name, Class::Uniform, Type::Point, p)
}

/// Make the requests of the scene.
fn request_bed(ri: &mut impl Ri, job: &RenderBench) -> Result<(), Fail> {
    let bed = Bed::new(job.n, job.motion);
    request_camera(ri, job, &bed)?;
    ri.world_begin()?;
    ri.shading_rate(job.shading_rate)?;
    let (from, to) = (point("from", [0.0; 3]), point("to", [0.5, 0.4, -0.8]));
    ri.light_source("distantlight", "sun", vec![float("intensity", 1.0), from, to])?;
    if job.sky {
        ri.light_source("skylight", "sky", vec![])?;
    }
    ri.surface("matte", vec![float("Ka", job.sky as u8 as f32), float("Kd", 1.0)])?;
    ri.attribute_begin()?;
    ri.color([0.5; 3])?;
    let [x, y0, y1] = [8.0, 0.5, 12.0].map(|factor| (factor * bed.height) as f32);
    let ground = [-x, y0, 0.0, x, y0, 0.0, x, y1, 0.0, -x, y1, 0.0];
    ri.polygon(vec![Param::floats("P", Class::Vertex, Type::Point, ground)])?;
    ri.attribute_end()?;
    ri.instances(Instances {
        moved: bed.moved.map(|moved| ([0.0, 1.0], moved)),
        shape: InstanceShape::Sphere,
        scale: vec![[RADIUS as f32; 3]; bed.position.len()],
        position: bed.position,
        orientation: vec![],
        offset: vec![],
        params: vec![Param::floats("Cs", Class::Uniform, Type::Color, bed.color)],
    })?;
    ri.world_end()
}

/// Make the requests of the options and of the camera, which looks down at 30°.
fn request_camera(ri: &mut impl Ri, job: &RenderBench, bed: &Bed) -> Result<(), Fail> {
    let h = bed.height;
    let [width, height] = job.resolution.map(|n| n as i32);
    ri.format(width, height, 1.0)?;
    ri.display("bed.png", "png", "rgb", vec![])?;
    ri.shutter(0.0, 1.0)?;
    if let Some(f_stop) = job.f_stop {
        // The ray through the middle meets the bed at twice the camera's height.
        ri.depth_of_field(f_stop, 0.05 * h as f32, 2.0 * h as f32)?;
    }
    ri.pixel_samples(4.0, 4.0)?;
    ri.pixel_filter("box", 1.0, 1.0)?;
    ri.exposure(1.0, 2.2)?;
    ri.projection("perspective", vec![float("fov", 30.0)])?;
    ri.clipping(0.05, 20.0 * h as f32)?;
    let (s, c) = 30f64.to_radians().sin_cos();
    let axes = [[1.0, 0.0, 0.0], [0.0, s, c], [0.0, c, -s]];
    let eye = [0.0, 0.0, (LAYERS - 1) as f64 * bed.layer + 2.0 * RADIUS + h];
    let mut matrix = [0.0f32; 16];
    for (column, axis) in axes.iter().enumerate() {
        for row in 0..3 {
            matrix[4 * row + column] = axis[row] as f32;
        }
        matrix[12 + column] = -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]) as f32;
    }
    matrix[15] = 1.0;
    ri.concat_transform(matrix)
}
