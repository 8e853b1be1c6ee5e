//! Quadrics as bicubic patches: profiles, swept about the z axis.

use crate::scene::patch::Patch;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::OnceLock;

/// The greatest arc of a patch: it misses the circle by less than 1e-6 of its radius.
const ARC: f32 = 30.0;

/// Pieces of a parabola.
const PARABOLA_PIECES: usize = 8;

/// Pieces around a whole circle.
pub const AROUND: usize = (360.0 / ARC) as usize;

/// A piece of a profile: a cubic curve in space, and its range of v.
pub type Profile = ([Vec3; 4], [f32; 2]);

/// A quadric: a profile, swept about the z axis by an angle in degrees.
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    /// The profile.
    pub outline: Outline,
    /// The angle.
    pub sweep: f32,
}

/// The profile of a quadric.
#[derive(Clone, Copy, Debug)]
pub enum Outline {
    /// From one point to another.
    Line(Vec3, Vec3),
    /// About a centre (r, z), of a radius, from one angle to another, radians.
    Circle([f32; 2], f32, [f32; 2]),
    /// Of a radius, from one z to another.
    Parabola(f32, [f32; 2]),
}

impl Quadric {
    /// Pieces of its profile, and pieces around.
    pub fn pieces(&self) -> [usize; 2] {
        let along = match self.outline {
            Outline::Line(..) => 1,
            Outline::Circle(_, _, [from, to]) => pieces(to - from),
            Outline::Parabola(..) => PARABOLA_PIECES,
        };
        [along, pieces(self.sweep.to_radians())]
    }

    /// Its radius, if it is a whole sphere.
    pub fn whole_sphere(&self) -> Option<f32> {
        match self.outline {
            Outline::Circle([0.0, 0.0], radius, [from, to])
                if from <= -FRAC_PI_2 && to >= FRAC_PI_2 && self.sweep.abs() >= 360.0 =>
            {
                Some(radius)
            }
            _ => None,
        }
    }

    /// The greatest angle, radians, by which a point of it turns on the way to another of its kind; of a parabola, as far as its
    /// profile is bent.
    pub fn turned_to(&self, other: &Quadric) -> f32 {
        let bent = match (self.outline, other.outline) {
            (Outline::Circle(_, _, a), Outline::Circle(_, _, b)) => {
                (0..2).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max)
            }
            (Outline::Parabola(_, a), Outline::Parabola(_, b)) if a != b => FRAC_PI_2,
            _ => 0.0,
        };
        bent.max((self.sweep - other.sweep).to_radians().abs().min(TAU))
    }

    /// The quadric whose numbers are on the way to those of another of its kind; itself if that is of another.
    pub fn mixed(&self, other: &Quadric, part: f32) -> Quadric {
        let mix = |a: f32, b: f32| a + (b - a) * part;
        let outline = match (self.outline, other.outline) {
            (Outline::Line(a, b), Outline::Line(c, d)) => Outline::Line(a.lerp(c, part), b.lerp(d, part)),
            (Outline::Circle(a, r, angles), Outline::Circle(b, s, others)) => {
                let radius = mix(r, s);
                // A sphere is cut at heights.
                let is_sphere = a == [0.0; 2] && b == [0.0; 2] && radius != 0.0;
                let angle = |k: usize| {
                    let height = mix(r * angles[k].sin(), s * others[k].sin());
                    if is_sphere { (height / radius).clamp(-1.0, 1.0).asin() } else { mix(angles[k], others[k]) }
                };
                Outline::Circle([mix(a[0], b[0]), mix(a[1], b[1])], radius, [angle(0), angle(1)])
            }
            (Outline::Parabola(r, a), Outline::Parabola(s, b)) => {
                Outline::Parabola(mix(r, s), [mix(a[0], b[0]), mix(a[1], b[1])])
            }
            (outline, _) => outline,
        };
        Quadric { outline, sweep: mix(self.sweep, other.sweep) }
    }

    /// Its patches, of so many pieces.
    pub fn patches(&self, [along, around]: [usize; 2]) -> Vec<Patch> {
        let profile = match self.outline {
            Outline::Line(a, b) => evenly(a, b, along),
            Outline::Circle(center, radius, [from, to]) => circle(center, radius, from, to, along),
            Outline::Parabola(radius, [z_min, z_max]) => parabola(radius, z_min, z_max, along),
        };
        revolve(&profile, self.sweep.clamp(-360.0, 360.0), around)
    }
}

/// A straight profile in pieces.
fn evenly(a: Vec3, b: Vec3, n: usize) -> Vec<Profile> {
    let at = |k: usize| k as f32 / n as f32;
    let piece = |k: usize| (line(a.lerp(b, at(k)), a.lerp(b, at(k + 1)))[0].0, [at(k), at(k + 1)]);
    if n == 1 { line(a, b) } else { (0..n).map(piece).collect() }
}

/// A straight profile.
pub fn line(a: Vec3, b: Vec3) -> Vec<Profile> {
    vec![([a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b], [0.0, 1.0])]
}

/// A circular profile about a centre (r, z) in the xz plane, from one angle to another, radians.
fn circle(center: [f32; 2], radius: f32, from: f32, to: f32, n: usize) -> Vec<Profile> {
    // Once around is all there is.
    let to = from + (to - from).clamp(-TAU, TAU);
    let at = |k: usize| k as f32 / n as f32;
    (0..n)
        .map(|k| {
            let points = arc(from + (to - from) * at(k), from + (to - from) * at(k + 1));
            let p = points.map(|[c, s]| Vec3::new(center[0] + radius * c, 0.0, center[1] + radius * s));
            (p, [at(k), at(k + 1)])
        })
        .collect()
}

/// A parabola from the tip: r = R √(z/z_max), from z_min to z_max.
fn parabola(radius: f32, z_min: f32, z_max: f32, n: usize) -> Vec<Profile> {
    // In r the profile is of second degree; v goes with z, so that short pieces follow it.
    let r_of = |z: f32| radius * (z / z_max).max(0.0).sqrt();
    let (r0, r1) = (r_of(z_min), r_of(z_max));
    let z_of = |r: f32| z_max * (r / radius) * (r / radius);
    let r_at = |k: usize| r0 + (r1 - r0) * k as f32 / n as f32;
    let v_of = |r: f32| if z_max != z_min { (z_of(r) - z_min) / (z_max - z_min) } else { 0.0 };
    (0..n)
        .map(|k| {
            let (a, b) = (r_at(k), r_at(k + 1));
            let (pa, pb) = (Vec3::new(a, 0.0, z_of(a)), Vec3::new(b, 0.0, z_of(b)));
            let slope = |r: f32| Vec3::new(1.0, 0.0, 2.0 * z_max * r / (radius * radius)) * (b - a) / 3.0;
            ([pa, pa + slope(a), pb - slope(b), pb], [v_of(a), v_of(b)])
        })
        .collect()
}

/// Pieces of an arc.
fn pieces(angle: f32) -> usize {
    (angle.abs().min(TAU).to_degrees() / ARC).ceil().max(1.0) as usize
}

/// Bézier points (cosine, sine) of the unit circle's arc between two angles.
fn arc(a: f32, b: f32) -> [[f32; 2]; 4] {
    let k = 4.0 / 3.0 * ((b - a) / 4.0).tan();
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    [[ca, sa], [ca - k * sa, sa + k * ca], [cb + k * sb, sb - k * cb], [cb, sb]]
}

/// Sweep a profile about the z axis by an angle in degrees, in `n` pieces; u goes around, v along the profile.
pub fn revolve(profile: &[Profile], sweep: f32, n: usize) -> Vec<Patch> {
    let turn = sweep.to_radians();
    let at = |k: usize| k as f32 / n as f32;
    let mut patches = Vec::new();
    for (curve, v) in profile {
        for i in 0..n {
            let around = arc(turn * at(i), turn * at(i + 1));
            let mut p = [Vec3::ZERO; 16];
            for (k, q) in p.iter_mut().enumerate() {
                let (c, [cos, sin]) = (curve[k / 4], around[k % 4]);
                *q = Vec3::new(c.x * cos - c.y * sin, c.x * sin + c.y * cos, c.z);
            }
            patches.push(Patch::smooth(p, [at(i), at(i + 1)], *v));
        }
    }
    patches
}

/// The patches of the unit sphere.
pub fn whole_sphere() -> &'static [Patch] {
    static PATCHES: OnceLock<Vec<Patch>> = OnceLock::new();
    PATCHES.get_or_init(|| {
        let quarter = 0.5 * std::f32::consts::PI;
        let sphere = Quadric { outline: Outline::Circle([0.0; 2], 1.0, [-quarter, quarter]), sweep: 360.0 };
        sphere.patches(sphere.pieces())
    })
}
