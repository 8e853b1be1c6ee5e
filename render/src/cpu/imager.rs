//! Imager shaders: the filtered pixels of a bucket go through them before exposure (RISpec 4.1.6, 15.5).

use crate::scene::world::Scene;
use sl::ir::Ask;
use sl::machine::{Answer, BoundShader, Machine, MapQuery, Points};
use std::sync::Arc;

/// The scene as an imager asks it: spaces, maps and options.
struct ImagerScene<'a>(&'a Scene);

impl sl::machine::Scene for ImagerScene<'_> {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &[]
    }
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        self.0.matrix(from, to, &|_| None)
    }
    fn transmission(&self, _: [f32; 3], _: [f32; 3]) -> [f32; 3] {
        [1.0; 3]
    }
    fn map(&self, query: &MapQuery) -> [f32; 4] {
        self.0.textures.look_up(query, &self.0.warnings)
    }
    fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        self.0.ask(what, names)
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
    points.inputs.clear();
    let place = |k: usize| [(x + k % width) as f32 + 0.5, (y + k / width) as f32 + 0.5, 0.0];
    points.refill("P").extend((0..3).flat_map(|c| (0..n).map(move |k| place(k)[c])));
    points.refill("Ci").extend((0..3).flat_map(|c| pixels.iter().map(move |p| p[c])));
    points.refill("Oi").extend((0..3).flat_map(|_| pixels.iter().map(|p| p[3])));
    points.refill("alpha").extend(pixels.iter().map(|p| p[3]));
    points.refill("ncomps").push(3.0);
    machine.run(imager, points, &ImagerScene(scene));
    let value = |name: &str, c: usize, k: usize, width: usize| {
        let v = points.get(name).unwrap_or(&[]);
        if v.len() == width { v[c] } else { v.get(c * n + k).copied().unwrap_or(0.0) }
    };
    for (k, pixel) in pixels.iter_mut().enumerate() {
        *pixel = [value("Ci", 0, k, 3), value("Ci", 1, k, 3), value("Ci", 2, k, 3), value("alpha", 0, k, 1)];
    }
}
