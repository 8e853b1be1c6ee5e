//! Cones about fixed directions that cover all directions, and how much of each is open.

use glam::Vec3;
use std::sync::OnceLock;

/// Number of cones.
pub const CONES: usize = 24;

/// Cosine and sine of the angle between a cone's axis and its side: together the cones cover all directions once, and a half.
pub const COS: f32 = 0.875;
pub const SIN: f32 = 0.484_122_9;

/// The solid angle of a cone.
pub const SOLID: f32 = std::f32::consts::TAU * (1.0 - COS);

/// The cones' axes, by component.
pub struct Axes {
    pub x: [f32; CONES],
    pub y: [f32; CONES],
    pub z: [f32; CONES],
}

/// How much of each cone is open, 0 to 1.
#[derive(Clone, Copy)]
pub struct Cones(pub [f32; CONES]);

impl Cones {
    /// Nothing is closed.
    pub const OPEN: Cones = Cones([1.0; CONES]);
}

/// Colours of what closes cones, summed by how much of what lights the point each closes.
#[derive(Clone, Copy, Default)]
pub struct Tint {
    sum: Vec3,
    weight: f32,
}

impl Tint {
    #[inline(always)]
    pub fn add(&mut self, color: Packed, weight: f32) {
        self.sum += color.color() * weight;
        self.weight += weight;
    }

    /// Their mean.
    pub fn mean(&self) -> Vec3 {
        if self.weight > 0.0 { self.sum / self.weight } else { Vec3::ZERO }
    }
}

/// A colour in ten bits a channel, as a device has it, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packed(pub u32);

impl Packed {
    pub fn new(color: [f32; 3]) -> Packed {
        let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0) * 1023.0).round() as u32);
        Packed(r | g << 10 | b << 20)
    }

    #[inline(always)]
    pub fn color(self) -> Vec3 {
        Vec3::new((self.0 & 1023) as f32, (self.0 >> 10 & 1023) as f32, (self.0 >> 20 & 1023) as f32) * (1.0 / 1023.0)
    }
}

/// The axes, evenly spread along a spiral.
pub fn cones() -> &'static [Vec3; CONES] {
    static ALL: OnceLock<[Vec3; CONES]> = OnceLock::new();
    ALL.get_or_init(|| {
        std::array::from_fn(|k| {
            let z = 1.0 - (2.0 * k as f64 + 1.0) / CONES as f64;
            let (sin, cos) = (k as f64 * std::f64::consts::PI * (3.0 - 5f64.sqrt())).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32)
        })
    })
}

/// The same by component.
pub fn axes() -> &'static Axes {
    static ALL: OnceLock<Axes> = OnceLock::new();
    ALL.get_or_init(|| {
        let of = |c: usize| std::array::from_fn(|k| cones()[k][c]);
        Axes { x: of(0), y: of(1), z: of(2) }
    })
}

/// 3 x² − 2 x³
#[inline(always)]
pub fn smooth(x: f32) -> f32 {
    x * x * (3.0 - 2.0 * x)
}

/// How bright a dull sphere is in the mean, of 1 square to the sun, by the cosine of the way that it is seen along and the way to the sun: close
/// to Lambert's 2 (sin α + (π − α) cos α) / 3π of the phase α.
#[inline(always)]
pub fn phase(cos: f32) -> f32 {
    let half = 0.5 - 0.5 * cos;
    half * (0.1833 + 0.4833 * half)
}

/// A disc in the sky as cones see it: the overlap of two spherical caps as a smooth step (Oat and Sander 2007), scaled so that it covers
/// its solid angle.
pub struct Cap {
    way: Vec3,
    /// The cosine from which on the disc covers something, and one over the width to where it covers its most.
    from: f32,
    scale: f32,
    most: f32,
}

impl Cap {
    /// Of a direction, the sine squared of the disc's radius, and a factor on what it covers.
    #[inline(always)]
    pub fn new(way: Vec3, sin2: f32, factor: f32) -> Cap {
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).sqrt());
        let (from, full) = (cos * COS - sin * SIN, cos * COS + sin * SIN);
        // So that over all directions it covers its own solid angle: the fading edge alone would reach farther.
        let most = (1.0 - cos) / (1.0 - cos * COS) * factor;
        Cap { way, from, scale: 1.0 / (full - from).max(1e-6), most }
    }

    /// How much of each cone it covers.
    #[inline(always)]
    pub fn covers(&self, axes: &Axes) -> [f32; CONES] {
        let mut out = [0.0; CONES];
        for (k, out) in out.iter_mut().enumerate() {
            let cos = self.way.x * axes.x[k] + self.way.y * axes.y[k] + self.way.z * axes.z[k];
            *out = self.most * smooth(((cos - self.from) * self.scale).clamp(0.0, 1.0));
        }
        out
    }
}
