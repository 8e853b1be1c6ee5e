//! A grid of micropolygons: displaced, projected, shaded and handed to the samples.

use crate::cpu::blur::Track;
use crate::cpu::bucket::Job;
use crate::cpu::samples::Look;
use crate::cpu::view::View;
use crate::cpu::visible::hold;
use crate::film::display::placed;
use crate::scene::camera::Camera;
use crate::scene::motion::Instant;
use crate::scene::source::{Item, ItemView, instance_inputs};
use glam::{Vec2, Vec3};
use sl::machine::Points;

/// A grid: points in rows, in world space, and where they fall on the raster.
#[derive(Default)]
pub struct Grid {
    /// P, N, u, v, s, t as the dicer left them.
    pub points: Points,
    /// Raster x and y, pixels, and depth, at each moment of the item.
    raster: Vec<Vec<[f32; 3]>>,
    /// Of its primitive variables, how many are the same all over; they come first.
    pub uniform: usize,
    /// Micropolygons that are sampled, by their first points.
    micropolygons: Vec<u32>,
}

/// What a dicer says of its grid.
pub struct Diced {
    /// An extra ring of points all around, for derivatives, which is dropped after displacement.
    pub apron: bool,
    /// After displacement, points of an edge that its neighbour does not have are put onto the line between those that it has:
    /// by bits, the points that are kept of the edges at the first row, last row, first column, last column.
    pub keep: [u32; 4],
}

/// The greatest displacement of an item in world units.
pub fn displacement_reach(view: &ItemView<'_>, size: f32) -> f32 {
    if view.attributes.displacement.is_none() {
        return 0.0;
    }
    let scale = view.object_to_world.x_axis.truncate().length();
    view.attributes.displacement_bound.map_or(0.1 * size, |b| b * scale)
}

/// Displace, project, shade and sample the grid that a dicer has left in `job.grid`; `reach` is how far it may be displaced.
pub fn finish(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, diced: &Diced, reach: f32) {
    let a = view.attributes;
    let frame = job.frame;
    uniform_inputs(&mut job.grid.points, view);
    if let Some(displacement) = &a.displacement {
        let mut scene = View::new(frame.scene, &frame.bvh, item, view, [0.0; 2]);
        scene.shader_to_world = a.displacement_space;
        fill_incident(&mut job.grid.points, &frame.camera);
        let before = job.grid.points.get("P").unwrap_or(&[]).to_vec();
        job.machine.run(displacement, &mut job.grid.points, &scene);
        spread(&mut job.grid.points);
        let after = job.grid.points.get("P").unwrap_or(&[]);
        let n = job.grid.points.n();
        let moved = |k: usize| (0..3).map(|c| (after[c * n + k] - before[c * n + k]).powi(2)).sum::<f32>();
        let farthest = (0..n).map(moved).fold(0.0, f32::max).sqrt();
        if farthest > reach * 1.001 && farthest.is_finite() {
            let scale = view.object_to_world.x_axis.truncate().length();
            frame.scene.needs_bound(&displacement.program.name, farthest / scale.max(f32::MIN_POSITIVE));
        }
    }
    if diced.apron {
        strip_apron(&mut job.grid.points);
    }
    job.grid.points.inputs.append(&mut job.uniform);
    job.grid.uniform = job.grid.points.inputs.len();
    job.grid.points.inputs.append(&mut job.varying);
    if diced.keep != [u32::MAX; 4] {
        let (nu, nv) = (job.grid.points.nu, job.grid.points.nv);
        let p = job.grid.points.globals.iter_mut().filter(|(name, _)| *name == "P").map(|(_, p)| p);
        p.chain(&mut job.deformed).for_each(|p| snap_edges(p, nu, nv, diced.keep));
    }
    let Some((min, max, z)) = job.grid.project(&frame.camera, &job.instants, &job.deformed) else { return };
    job.stats.grids += 1;
    if !job.touches(min, max) || job.samples.hides([min[0], min[1]], [max[0], max[1]], z) {
        job.stats.grids_hidden += 1;
        return;
    }
    // What is surely opaque is shaded when the bucket knows what of it is seen.
    let later = a.stays_opaque() && !job.grid.points.inputs.iter().any(|(name, _)| name == "Os");
    if !later {
        let mut points = std::mem::take(&mut job.grid.points);
        shade(job, item, view, &mut points, reach, z);
        job.grid.points = points;
    }
    let opaque = later || surface_opacity(&job.grid.points).iter().all(|o| *o >= 1.0);
    if sample(job, item, view, opaque) {
        hold(job, item, !later, reach, z);
    }
}

/// Shade points of an item, whose grid may be displaced by `reach` and is at depth `z` or behind.
pub fn shade(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, points: &mut Points, reach: f32, z: f32) {
    let (a, frame) = (view.attributes, job.frame);
    let begun = std::time::Instant::now();
    // A displaced surface does not shadow itself with what it was before.
    let bias = 2.0 / frame.camera.pixels_at(z);
    let mut scene = View::new(frame.scene, &frame.bvh, item, view, [bias, bias + 2.0 * reach]);
    fill_incident(points, &frame.camera);
    surface_globals(points, view, frame.camera.eye);
    job.machine.run(&a.surface, points, &scene);
    note_outputs(job, item, view, points);
    if let Some(atmosphere) = &a.atmosphere {
        scene.shader_to_world = a.atmosphere_space;
        job.machine.run(atmosphere, points, &scene);
    }
    job.stats.shaded_points += points.n() as u64;
    job.stats.seconds.shade += begun.elapsed().as_secs_f64();
}

/// Put what displays take besides colour into `job.outputs`, point after point, as the surface shader has left it; what is not
/// known before the grid is sampled stays 0.
fn note_outputs(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, points: &Points) {
    let (frame, n) = (job.frame, points.n());
    job.outputs.clear();
    if frame.aovs.is_empty() {
        return;
    }
    let mut outputs = std::mem::take(&mut job.outputs);
    outputs.resize(n * frame.depth, 0.0);
    let id = [(frame.numbers[item.source as usize] + item.index as usize) as f32];
    for (first, aov) in placed(frame.aovs) {
        let (width, name) = (aov.width(), aov.name.as_str());
        let variable = || points.inputs.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_slice());
        let values = match name {
            "z" | "motion" => None,
            "id" => Some(&id[..]),
            "Ng" => points.get("Ng").filter(|v| !v.is_empty()).or(points.get("N")),
            _ => job.machine.output(&view.attributes.surface, name).or(points.get(name)).or_else(variable),
        };
        if let Some(values) = values.filter(|v| v.len() == width || v.len() == width * n) {
            for (k, out) in outputs.chunks_exact_mut(frame.depth).enumerate() {
                for c in 0..width {
                    out[first + c] = if values.len() == width { values[c] } else { values[c * n + k] };
                }
            }
        }
    }
    job.outputs = outputs;
}

/// The opacity that shading left: one, or one a point.
pub fn surface_opacity(points: &Points) -> &[f32] {
    points.get("Oi").unwrap_or(&[1.0; 3])
}

/// Sample the grid at hand; whether anything of it is seen.
fn sample(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, opaque: bool) -> bool {
    let begun = std::time::Instant::now();
    let frame = job.frame;
    let points = &job.grid.points;
    let (n, nu, nv) = (points.n(), points.nu, points.nv);
    let (place, normal) = (points.get("P").unwrap_or(&[]), points.get("N").unwrap_or(&[]));
    // Of a one-sided primitive, micropolygons that face away are not there.
    let away = |k: usize| {
        let at = |v: &[f32]| Vec3::new(v[k], v[n + k], v[2 * n + k]);
        at(normal).dot(frame.camera.incident(at(place))) > 0.0
    };
    let raster = &job.grid.raster;
    let behind = |k: usize| raster.iter().any(|raster| !(raster[k][2] >= frame.camera.near));
    let any_behind = (0..n).any(behind);
    let micropolygons = &mut job.grid.micropolygons;
    micropolygons.clear();
    for j in 0..nv - 1 {
        for i in 0..nu - 1 {
            let k = j * nu + i;
            if job.trimmed.get(j * (nu - 1) + i) == Some(&true)
                || (any_behind && [k, k + 1, k + nu + 1, k + nu].into_iter().any(behind))
                || (!view.attributes.two_sided && away(k))
            {
                continue;
            }
            micropolygons.push(k as u32);
        }
    }
    let primitive = (item.source as u64) << 32 | item.index as u64;
    let look = Look { grid: job.held.next(), opaque, smooth: view.attributes.smooth, primitive };
    // Without a lens, what stands still in a picture of motion is sampled as if it moved.
    let tally = if frame.jitter.moments.is_some() {
        let track = Track { instants: &job.instants, raster, camera: &frame.camera, jitter: &frame.jitter };
        job.samples.blurred(nu, micropolygons, &track, &look)
    } else {
        job.samples.still(&raster[0], nu, micropolygons, &look)
    };
    job.stats.micropolygons += micropolygons.len() as u64;
    job.stats.samples += tally.tried;
    job.stats.seconds.sample += begun.elapsed().as_secs_f64();
    tally.hit
}

impl Grid {
    /// How far each point moves on the raster while the shutter is open, pixels to the right and down.
    pub fn motion(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        let (first, last) = (self.raster.first(), self.raster.last());
        let both = first.into_iter().flatten().zip(last.into_iter().flatten());
        both.map(|(a, b)| if b[2] > f32::NEG_INFINITY { [b[0] - a[0], b[1] - a[1]] } else { [0.0; 2] })
    }

    /// Project all points at all moments; the bound on the raster, blur included, and the least depth, `None` if nothing is before
    /// the near plane.
    fn project(
        &mut self,
        camera: &Camera,
        instants: &[Instant],
        deformed: &[Vec<f32>],
    ) -> Option<([f32; 2], [f32; 2], f32)> {
        let n = self.points.n();
        let p = self.points.get("P")?;
        let (mut min, mut max, mut z) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2], f32::INFINITY);
        self.raster.resize_with(instants.len(), Vec::new);
        for (moment, (instant, raster)) in instants.iter().zip(&mut self.raster).enumerate() {
            let off = moment.checked_sub(1).and_then(|k| deformed.get(k));
            raster.clear();
            for k in 0..n {
                let mut at = Vec3::new(p[k], p[n + k], p[2 * n + k]);
                if let Some(off) = off {
                    at += Vec3::new(off[k], off[n + k], off[2 * n + k]);
                }
                let c = instant.to_camera.transform_point3(at);
                if !(c.z >= camera.near && c.is_finite()) {
                    raster.push([0.0, 0.0, f32::NEG_INFINITY]);
                    continue;
                }
                let r = on_steps(camera.project(c));
                let spread = camera.confusion(c.z).abs();
                raster.push([r.x, r.y, c.z]);
                min = [min[0].min(r.x - spread), min[1].min(r.y - spread)];
                max = [max[0].max(r.x + spread), max[1].max(r.y + spread)];
                z = z.min(c.z);
            }
        }
        (z <= camera.far).then_some((min, max, z))
    }
}

/// A raster point on steps of 1/1024 pixel: single precision then takes differences of places without rounding, so that pictures
/// do not depend on how they are cut to buckets.
fn on_steps(r: Vec2) -> Vec2 {
    // Of a sum of this size the last place is worth a step.
    const SHIFT: f32 = 12_288.0;
    (r + SHIFT) - SHIFT
}

/// The variables of a primitive that are the same all over, for whichever of its shaders runs.
pub fn uniform_inputs(points: &mut Points, view: &ItemView<'_>) {
    let own = view.instance.into_iter().flat_map(|(columns, i)| instance_inputs(columns, i));
    points.inputs.clear();
    points.inputs.extend(view.source.uniform.iter().cloned().chain(own));
}

/// What a surface shader starts with besides where it is: colours, and Ng and E if it asks for them.
pub fn surface_globals(points: &mut Points, view: &ItemView<'_>, eye: Vec3) {
    let a = view.attributes;
    let varies = |name: &str| points.inputs.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
    let (cs, os) = (varies("Cs").unwrap_or(view.color.to_vec()), varies("Os").unwrap_or(a.opacity.to_vec()));
    points.refill("Cs").extend_from_slice(&cs);
    points.refill("Os").extend_from_slice(&os);
    points.refill("Ci").extend_from_slice(&[0.0; 3]);
    points.refill("Oi").extend_from_slice(&os);
    if a.surface.program.global("Ng").is_some() {
        let normal = points.get("N").unwrap_or(&[]).to_vec();
        points.refill("Ng").extend(normal);
    }
    if a.surface.program.global("E").is_some() {
        points.refill("E").extend_from_slice(&eye.to_array());
    }
}

/// I at every point, and a uniform P or N made varying, as projection wants it.
fn fill_incident(points: &mut Points, camera: &Camera) {
    spread(points);
    let n = points.n();
    let mut i = std::mem::take(points.refill("I"));
    i.resize(3 * n, 0.0);
    let p = points.get("P").unwrap_or(&[]);
    for k in 0..n {
        let v = camera.incident(Vec3::new(p[k], p[n + k], p[2 * n + k]));
        (i[k], i[n + k], i[2 * n + k]) = (v.x, v.y, v.z);
    }
    *points.refill("I") = i;
}

/// A shader may have left P or N the same everywhere.
fn spread(points: &mut Points) {
    let n = points.n();
    for (_, v) in points.globals.iter_mut().filter(|(name, v)| matches!(*name, "P" | "N") && v.len() == 3 && n > 1) {
        *v = v.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect();
    }
}

/// Drop the ring of points around the grid.
fn strip_apron(points: &mut Points) {
    let (nu, nv, n) = (points.nu, points.nv, points.n());
    for (_, v) in &mut points.globals {
        if v.len() >= n && v.len() % n == 0 {
            let mut kept = Vec::with_capacity(v.len());
            for c in 0..v.len() / n {
                for j in 1..nv - 1 {
                    let row = c * n + j * nu;
                    kept.extend_from_slice(&v[row + 1..row + nu - 1]);
                }
            }
            *v = kept;
        }
    }
    points.nu -= 2;
    points.nv -= 2;
}

/// Put the points of an edge that its neighbour does not have onto the line between those that it has.
fn snap_edges(p: &mut [f32], nu: usize, nv: usize, keep: [u32; 4]) {
    let n = nu * nv;
    let edges = [(0, 1, nu), ((nv - 1) * nu, 1, nu), (0, nu, nv), (nu - 1, nu, nv)];
    for ((start, stride, count), keep) in edges.into_iter().zip(keep) {
        let kept = |i: usize| keep >> i & 1 == 1;
        for i in (1..count - 1).filter(|i| !kept(*i)) {
            let a = (0..i).rev().find(|k| kept(*k)).unwrap_or(0);
            let b = (i..count).find(|k| kept(*k)).unwrap_or(count - 1);
            let t = (i - a) as f32 / (b - a) as f32;
            for c in 0..3 {
                let at = |k: usize| c * n + start + k * stride;
                p[at(i)] = p[at(a)] * (1.0 - t) + p[at(b)] * t;
            }
        }
    }
}
