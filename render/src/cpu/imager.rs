//! Imager shaders: the filtered and exposed pixels of a bucket go through them (RISpec 4.1.2, figure 4.2).

use crate::cpu::frame::Frame;
use crate::film::bucket::Bucket;
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

/// Take the filtered pixels of a bucket through the imager, if there is one. What surfaces say that a display shows of them is taken out
/// before and put back after it: no gain changes it, and no imager; gamma alone does, as it does for all that is shown. `extra` has what displays take
/// besides colour, [`Frame::depth`] numbers a pixel.
pub fn pass(
    frame: &Frame<'_>,
    (machine, points): (&mut Machine, &mut Points),
    bucket: &Bucket,
    (pixels, extra): (&mut [[f32; 4]], &[f32]),
) {
    let (options, scene) = (frame.options, frame.scene);
    let shown: Vec<(usize, Shown)> = match frame.shown {
        Some(offsets) => {
            let all = extra.chunks_exact(frame.depth).enumerate();
            all.map(|(k, own)| (k, Shown::of(own, offsets))).filter(|(_, shown)| shown.is_any()).collect()
        }
        None => vec![],
    };
    let Some(imager) = &options.imager else {
        // These are exposed when the image is whole.
        if options.gain != 0.0 {
            shown.iter().for_each(|(k, shown)| shown.weaken(&mut pixels[*k], options.gain));
        }
        return;
    };
    shown.iter().for_each(|(k, shown)| shown.take_from(&mut pixels[*k]));
    expose(options, scene, pixels);
    run(imager, scene, machine, points, [bucket.x, bucket.y], bucket.width, pixels);
    shown.iter().for_each(|(k, shown)| shown.put_back(&mut pixels[*k], options.gamma));
}

/// The part of a pixel that a display shows as it is: its light, by how much it covers of each channel.
struct Shown {
    light: [f32; 3],
    cover: [f32; 3],
}

/// What is left of a pixel beside what covers it, below which that is nothing but rounding.
const LEAST_LEFT: f32 = 1e-4;

impl Shown {
    /// Of the numbers of a pixel, among which it has these offsets.
    fn of(extra: &[f32], [color, cover]: [usize; 2]) -> Shown {
        let triple = |at: usize| [extra[at], extra[at + 1], extra[at + 2]];
        Shown { light: triple(color), cover: triple(cover).map(|c| c.clamp(0.0, 1.0)) }
    }

    fn is_any(&self) -> bool {
        self.light != [0.0; 3] || self.cover != [0.0; 3]
    }

    fn mean_cover(&self) -> f32 {
        self.cover.iter().sum::<f32>() / 3.0
    }

    /// The rest of a pixel as if nothing covered it.
    fn take_from(&self, pixel: &mut [f32; 4]) {
        let rest = |all: f32, own: f32, cover: f32| {
            let left = all - own;
            let is_any = 1.0 - cover > LEAST_LEFT && left.abs() > 1e-5 * own.abs();
            if is_any { left / (1.0 - cover) } else { 0.0 }
        };
        let cover = self.mean_cover();
        (0..3).for_each(|c| pixel[c] = rest(pixel[c], self.light[c], self.cover[c]));
        pixel[3] = rest(pixel[3], cover, cover).clamp(0.0, 1.0);
    }

    /// Cover a pixel that an imager has left, whose colour is exposed.
    fn put_back(&self, pixel: &mut [f32; 4], gamma: f32) {
        let power = |x: f32, exponent: f32| if exponent == 1.0 { x } else { x.abs().powf(exponent).copysign(x) };
        for c in 0..3 {
            let behind = if self.cover[c] < 1.0 { (1.0 - self.cover[c]) * power(pixel[c], gamma) } else { 0.0 };
            pixel[c] = power(behind + self.light[c], 1.0 / gamma);
        }
        let cover = self.mean_cover();
        pixel[3] = cover + (1.0 - cover) * pixel[3];
    }

    /// Make its light in a pixel such that a gain brings it back.
    fn weaken(&self, pixel: &mut [f32; 4], gain: f32) {
        (0..3).for_each(|c| pixel[c] += self.light[c] * (1.0 / gain - 1.0));
    }
}

/// Expose pixels as an imager takes them, unless the scene hands it light: `Option "imager" "exposed"` 0.
fn expose(options: &Options, scene: &Scene, pixels: &mut [[f32; 4]]) {
    let said = scene.ask(Ask::Option, &["imager:exposed"]);
    if !matches!(said, Some(Answer::Numbers(v)) if v.first() == Some(&0.0)) {
        image::expose(pixels, options.gain, options.gamma);
    }
}

/// Run an imager over rows of `width` pixels whose first is at (`x`, `y`): P is the pixel's middle on the raster, Ci its
/// colour, Oi and alpha its coverage.
fn run(
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
