//! Imager shaders: the filtered and exposed pixels of a bucket go through them (RISpec 4.1.2, figure 4.2).

use crate::scene::world::Scene;
use sl::Global;
use sl::ir::Ask;
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
        queries.iter().zip(values).for_each(|(query, value)| *value = self.0.textures.look_up(query, &self.0.warnings));
    }
    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        self.0.ask(what, names)
    }
    fn print(&self, text: &str) {
        self.0.print(text);
    }
    fn stop(&self, message: &str) {
        self.0.stop(message);
    }

    fn warn(&self, message: String) {
        self.0.warn(message);
    }
    fn is_stopped(&self) -> bool {
        self.0.stopped().is_some()
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
    let n = pixels.len();
    (points.nu, points.nv, points.orientation) = (width, n / width, 1.0);
    let place = |k: usize| [(x + k % width) as f32 + 0.5, (y + k / width) as f32 + 0.5, 0.0];
    points.refill(Global::P).extend((0..3).flat_map(|c| (0..n).map(move |k| place(k)[c])));
    points.refill(Global::Ci).extend((0..3).flat_map(|c| pixels.iter().map(move |p| p[c])));
    points.refill(Global::Oi).extend((0..3).flat_map(|_| pixels.iter().map(|p| p[3])));
    points.refill(Global::Alpha).extend(pixels.iter().map(|p| p[3]));
    machine.run(imager, points, &ImagerScene(scene));
    let value = |global, c: usize, k: usize, width: usize| {
        let v = points.get(global).unwrap_or(&[]);
        if v.len() == width { v[c] } else { v.get(c * n + k).copied().unwrap_or(0.0) }
    };
    for (k, pixel) in pixels.iter_mut().enumerate() {
        *pixel = [
            value(Global::Ci, 0, k, 3),
            value(Global::Ci, 1, k, 3),
            value(Global::Ci, 2, k, 3),
            value(Global::Alpha, 0, k, 1),
        ];
    }
}
