//! Rolling ground: waves of random direction and phase, ditches, and boulders.

use crate::SplitMix64;
use crate::model_file::TerrainFile;
use glam::{DVec2, DVec3};

/// Number of waves.
const WAVES: usize = 24;

/// A wave: wave vector, rad/m, phase, rad, and weight of its amplitude; the weights add up to 1.
#[derive(Clone, Copy, Debug)]
struct Wave {
    k: DVec2,
    phase: f64,
    weight: f64,
}

/// The ground: its height as a function of x and y from the terrain's middle, m.
pub struct Ground<'a> {
    file: &'a TerrainFile,
    waves: Vec<Wave>,
}

impl<'a> Ground<'a> {
    /// The ground of a terrain, with waves drawn from a generator.
    pub fn new(file: &'a TerrainFile, random: &mut SplitMix64) -> Ground<'a> {
        let mut waves: Vec<Wave> = (0..WAVES)
            .map(|i| {
                // From the longest wave down to an eighth of it, shorter ones lower.
                let length = file.wavelength * 8f64.powf(-(i as f64) / (WAVES - 1) as f64);
                let way = random.between(0.0, std::f64::consts::TAU);
                Wave {
                    k: DVec2::from_angle(way) * (std::f64::consts::TAU / length),
                    phase: random.between(0.0, std::f64::consts::TAU),
                    weight: length / file.wavelength,
                }
            })
            .collect();
        let sum: f64 = waves.iter().map(|w| w.weight).sum();
        waves.iter_mut().for_each(|w| w.weight /= sum);
        Ground { file, waves }
    }

    /// Height at a point, m.
    pub fn height(&self, p: DVec2) -> f64 {
        // The weights add up to 1; the sum of waves is usually within a third of that.
        let wave: f64 = self.waves.iter().map(|w| w.weight * (w.k.dot(p) + w.phase).sin()).sum();
        let flat = self.file.flat_radius;
        let fade = if flat > 0.0 { smooth((p.length() - flat) / flat.max(1e-9)) } else { 1.0 };
        let mut z = self.file.amplitude * (3.0 * wave).clamp(-1.0, 1.0) * fade;
        for d in &self.file.ditches {
            let (a, b) = (DVec2::from(d.from), DVec2::from(d.to));
            let along = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-12)).clamp(0.0, 1.0);
            let away = (p - (a + (b - a) * along)).length();
            z -= d.depth * (1.0 - smooth(2.0 * away / d.width));
        }
        z
    }

    /// Heights on a grid: values by rows of x, m, counts, origin, m, and spacing, m.
    pub fn grid(&self) -> (Vec<f64>, [usize; 2], [f64; 2], [f64; 2]) {
        let n = self.file.size.map(|l| ((l / self.file.spacing).round() as usize).max(1) + 1);
        let spacing = [0, 1].map(|k| self.file.size[k] / (n[k] - 1) as f64);
        let origin = self.file.size.map(|l| -0.5 * l);
        let heights = (0..n[0] * n[1])
            .map(|i| {
                let (x, y) = ((i % n[0]) as f64, (i / n[0]) as f64);
                self.height(DVec2::new(origin[0] + x * spacing[0], origin[1] + y * spacing[1]))
            })
            .collect();
        (heights, n, origin, spacing)
    }

    /// Boulders: position from the terrain's middle, m, and radius, m; no two overlap, none is on the flat middle.
    pub fn boulders(&self, random: &mut SplitMix64) -> Vec<(DVec3, f64)> {
        let Some(file) = &self.file.boulders else { return vec![] };
        let mut placed: Vec<(DVec3, f64)> = vec![];
        let half = DVec2::from(self.file.size) * 0.5;
        for _ in 0..file.count.saturating_mul(40) {
            if placed.len() == file.count {
                break;
            }
            let radius = random.between(file.radius[0], file.radius[1]);
            let p = DVec2::new(random.between(-half.x, half.x), random.between(-half.y, half.y));
            let at = p.extend(self.height(p) + 0.15 * radius);
            let free = placed.iter().all(|(q, r)| (at - *q).length() > radius + r);
            if free && p.length() > self.file.flat_radius + radius {
                placed.push((at, radius));
            }
        }
        placed
    }
}

/// Smooth step from 0 at 0 to 1 at 1.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
