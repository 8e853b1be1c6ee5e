//! Shading of points by their surface and atmosphere shaders.

use crate::cpu::footprint;
use crate::cpu::frame::Frame;
use crate::cpu::globals::{fill_incident, surface_globals};
use crate::cpu::view::View;
use crate::film::display::{SHOWN, placed};
use crate::scene::source::{Item, ItemView};
use crate::stats::Stats;
use sl::Global;
use sl::ir::Ask;
use sl::machine::{Machine, Points};

/// What is shaded: points of an item.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// The item.
    pub item: Item,
    /// The item, looked up.
    pub view: &'a ItemView<'a>,
    /// How far the points may be displaced.
    pub reach: f32,
    /// Their least depth.
    pub z: f32,
    /// The part of the time that the shutter is open whose colour and opacity they have.
    pub time: f32,
}

/// The machine that shaders run on, and what displays take of the points that it shaded last.
#[derive(Default)]
pub struct Shading {
    /// The machine.
    pub machine: Machine,
    /// Values besides colour, one point's numbers after another's.
    pub outputs: Vec<f32>,
}

/// Shade points: give them Ci and Oi, and [`Shading::outputs`] what displays take besides.
pub fn shade(frame: &Frame<'_>, surface: &Surface<'_>, points: &mut Points, shading: &mut Shading, stats: &mut Stats) {
    let Surface { item, view, .. } = *surface;
    let a = view.attributes;
    let begun = std::time::Instant::now();
    let mut scene = prepare(frame, surface, points);
    shading.machine.run_with(&a.surface, &view.attached.surface, points, &scene);
    let n_lost = not_finite(points);
    if n_lost > 0 {
        frame.scene.not_finite(&a.surface.program, n_lost, item.source);
        limit(points);
    }
    note_outputs(frame, item, view, points, shading);
    if let Some(atmosphere) = &a.atmosphere {
        shading.machine.tell(Ask::Surface, &a.surface, points);
        scene.shader_to_world = a.atmosphere_space;
        let known = if n_lost > 0 { not_finite(points) } else { 0 };
        shading.machine.run_with(atmosphere, &view.attached.atmosphere, points, &scene);
        let more = not_finite(points).saturating_sub(known);
        if more > 0 {
            frame.scene.not_finite(&atmosphere.program, more, item.source);
            limit(points);
        }
    }
    if !a.keeps_opacity() || view.attached.opacity.is_some() {
        let n_beyond = beyond(surface_opacity(points), points.n());
        if n_beyond > 0 {
            frame.scene.not_opacities(&a.surface.program, n_beyond, item.source);
        }
    }
    if view.repeats > 1 {
        repeat(view, points);
    }
    points.footprints.clear();
    stats.shaded_points += points.n() as u64;
    stats.seconds.shade += begun.elapsed().as_secs_f64();
}

/// The greatest number that an image has of a surface: sums by any weights are numbers, too.
const GREATEST: f32 = 1e30;

/// Bring colours and opacities that are infinite into the range of an image.
fn limit(points: &mut Points) {
    for global in [Global::Ci, Global::Oi] {
        points.get_mut(global).into_iter().flatten().for_each(|x| *x = x.clamp(-GREATEST, GREATEST));
    }
}

/// Give points the colours and opacities of all primitives that theirs stands for.
fn repeat(view: &ItemView<'_>, points: &mut Points) {
    let n = points.n();
    let [mut color, mut opacity] = [Global::Ci, Global::Oi].map(|global| {
        let all = points.get(global).unwrap_or(&[1.0; 3]);
        if all.len() == 3 * n { all.to_vec() } else { all.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect() }
    });
    for k in 0..n {
        let of = |all: &[f32]| [0, 1, 2].map(|c| all[c * n + k]);
        let [ci, oi] = view.repeated([of(&color), of(&opacity)]);
        (0..3).for_each(|c| (color[c * n + k], opacity[c * n + k]) = (ci[c], oi[c]));
    }
    points.set(Global::Ci, color);
    points.set(Global::Oi, opacity);
}

/// How many points have opacities that lie beyond 0 and 1 by more than rounding.
fn beyond(opacity: &[f32], n: usize) -> usize {
    const ROUNDING: f32 = 1e-3;
    let is_beyond = |x: &f32| *x < -ROUNDING || *x > 1.0 + ROUNDING;
    if opacity.len() == 3 {
        return if opacity.iter().any(is_beyond) { n } else { 0 };
    }
    (0..n).filter(|k| (0..3).any(|c| opacity.get(c * n + k).is_some_and(is_beyond))).count()
}

/// Points whose colour or opacity is no finite number.
fn not_finite(points: &Points) -> usize {
    let n = points.n();
    let all = [Global::Ci, Global::Oi].map(|global| points.get(global).unwrap_or(&[]));
    // No branch, so that this costs nothing beside the shaders.
    let is_lost = |x: &f32| x.to_bits() & 0x7f80_0000 == 0x7f80_0000;
    if !all.iter().any(|v| v.iter().fold(false, |lost, x| lost | is_lost(x))) {
        return 0;
    }
    let at = |v: &[f32], k: usize| (0..3).any(|c| v.get(if v.len() == 3 { c } else { c * n + k }).is_some_and(is_lost));
    (0..n).filter(|k| all.iter().any(|v| at(v, *k))).count()
}

/// Give points what their shaders start with; the scene as they see it.
pub fn prepare<'a>(frame: &'a Frame<'_>, surface: &Surface<'a>, points: &mut Points) -> View<'a> {
    let Surface { item, view, reach, z, time } = *surface;
    fill_incident(points, &frame.camera);
    surface_globals(points, view, frame.camera.eye, time);
    if view.attributes.reads_neighbours() {
        footprint::fill(points, &frame.camera, view.attributes.shading_rate);
    }
    // A displaced surface does not shadow itself with what it was before.
    let bias = 2.0 / frame.camera.pixels_at(z);
    View::new(frame.scene, &frame.rays, item, view, [bias, bias + 2.0 * reach])
}

/// Put what displays take besides colour into the outputs, point after point, as the surface shader has left it; what is not
/// known before the grid is sampled stays 0.
fn note_outputs(frame: &Frame<'_>, item: Item, view: &ItemView<'_>, points: &Points, shading: &mut Shading) {
    let n = points.n();
    let Shading { machine, outputs } = shading;
    outputs.clear();
    if frame.aovs.is_empty() {
        return;
    }
    outputs.resize(n * frame.depth, 0.0);
    let id = [frame.scene.id_of(item) as f32];
    for (first, aov) in placed(&frame.aovs) {
        let (width, name) = (aov.width(), aov.name.as_str());
        let variable = || points.variable(view.attached.slot(name)?);
        let values = match name {
            "z" | "motion" => None,
            _ if view.attributes.matte && SHOWN.contains(&name) => None,
            "id" => Some(&id[..]),
            "Ng" => points.get(Global::Ng).filter(|v| !v.is_empty()).or(points.get(Global::N)),
            _ => machine
                .output(&view.attributes.surface, name)
                .or_else(|| points.get(Global::of_name(name)?))
                .or_else(variable),
        };
        if let Some(values) = values.filter(|v| v.len() == width || v.len() == width * n) {
            for (k, out) in outputs.chunks_exact_mut(frame.depth).enumerate() {
                for c in 0..width {
                    let value = if values.len() == width { values[c] } else { values[c * n + k] };
                    out[first + c] = value.clamp(-GREATEST, GREATEST);
                }
                if view.repeats > 1 && (name == "Ci" || name == "Oi") {
                    let at = |v: &[f32]| [0, 1, 2].map(|c| v[if v.len() == 3 { c } else { c * n + k }]);
                    let all = view.repeated([at(values), at(surface_opacity(points))]);
                    out[first..first + 3].copy_from_slice(&all[(name == "Oi") as usize]);
                }
            }
        }
    }
}

/// The opacity that shading left: one, or one a point.
pub fn surface_opacity(points: &Points) -> &[f32] {
    points.get(Global::Oi).unwrap_or(&[1.0; 3])
}
