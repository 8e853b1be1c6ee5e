//! Imager shaders: the filtered and exposed pixels of a bucket go through them (RISpec 4.1.2, figure 4.2).

use crate::film::image;
use crate::scene::options::Options;
use crate::scene::world::Scene;
use sl::Global;
use sl::ir::{Ask, Lookup};
use sl::machine::{Answer, BoundShader, Machine, MapQuery, Points};
use std::sync::Arc;

/// The scene as an imager asks it: spaces, maps and options.
struct ImagerScene<'a>(&'a Scene);

impl sl::machine::Scene for ImagerScene<'_> {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &[]
    }
    fn shutter(&self) -> [f32; 2] {
        self.0.shutter
    }
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        self.0.matrix(from, to, &|_| None)
    }
    fn map(&self, queries: &[MapQuery<'_>], values: &mut [[f32; 4]]) {
        queries.iter().zip(values).for_each(|(query, value)| *value = self.0.textures.look_up(query));
    }
    fn map_fault(&self, _: Lookup, name: &str, _: bool) -> Option<String> {
        self.0.textures.fault(name)
    }
    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        self.0.ask(what, names)
    }
    fn print(&self, text: &str) {
        self.0.print(text);
    }
    fn stop(&self, message: &str) {
        self.0.stop(None, message);
    }

    fn warn(&self, message: String) {
        self.0.warn(message);
    }
    fn is_stopped(&self) -> bool {
        self.0.stopped().is_some()
    }
}

/// Pixels that an imager is run over at a time, if it looks at each for itself: so that they stay in the caches.
const AT_A_TIME: usize = 512;

/// Expose pixels as an imager takes them, unless the scene hands it light: `Option "imager" "exposed"` 0.
pub fn expose(options: &Options, scene: &Scene, pixels: &mut [[f32; 4]]) {
    let said = scene.ask(Ask::Option, &["imager:exposed"]);
    if !matches!(said, Some(Answer::Numbers(v)) if v.first() == Some(&0.0)) {
        image::expose(pixels, options.gain, options.gamma);
    }
}

/// Run an imager over rows of `width` pixels whose first is at (`x`, `y`): P is the pixel's middle on the raster, Ci its
/// colour, Oi and alpha its coverage.
pub fn run(
    imager: &BoundShader,
    scene: &Scene,
    machine: &mut Machine,
    points: &mut Points,
    [x, y]: [usize; 2],
    width: usize,
    pixels: &mut [[f32; 4]],
) {
    let rows = if imager.program.reads_neighbours { usize::MAX } else { (AT_A_TIME / width.max(1)).max(1) };
    for (k, strip) in pixels.chunks_mut(rows.saturating_mul(width).max(1)).enumerate() {
        run_strip(imager, scene, machine, points, [x, y + k * rows], width, strip);
    }
}

/// The same of a few rows.
fn run_strip(
    imager: &BoundShader,
    scene: &Scene,
    machine: &mut Machine,
    points: &mut Points,
    [x, y]: [usize; 2],
    width: usize,
    pixels: &mut [[f32; 4]],
) {
    let n = pixels.len();
    let rows = n / width;
    (points.nu, points.nv, points.orientation) = (width, rows, 1.0);
    let p = points.refill(Global::P);
    (0..rows).for_each(|_| p.extend((x..x + width).map(|x| x as f32 + 0.5)));
    (y..y + rows).for_each(|y| p.resize(p.len() + width, y as f32 + 0.5));
    p.resize(3 * n, 0.0);
    let ci = points.refill(Global::Ci);
    (0..3).for_each(|c| ci.extend(pixels.iter().map(|p| p[c])));
    let oi = points.refill(Global::Oi);
    (0..3).for_each(|_| oi.extend(pixels.iter().map(|p| p[3])));
    points.refill(Global::Alpha).extend(pixels.iter().map(|p| p[3]));
    machine.run(imager, points, &ImagerScene(scene));
    let (ci, alpha) = (points.get(Global::Ci).unwrap_or(&[0.0; 3]), points.get(Global::Alpha).unwrap_or(&[0.0]));
    let runs = [sl::run_of(ci, 3, 0, n), sl::run_of(ci, 3, 1, n), sl::run_of(ci, 3, 2, n), sl::run_of(alpha, 1, 0, n)];
    for (c, run) in runs.into_iter().enumerate() {
        match run {
            [one] => pixels.iter_mut().for_each(|pixel| pixel[c] = *one),
            run => pixels.iter_mut().zip(run).for_each(|(pixel, x)| pixel[c] = *x),
        }
    }
}
