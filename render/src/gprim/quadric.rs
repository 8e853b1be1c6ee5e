//! Quadrics as bicubic patches: profiles, swept about the z axis.

use crate::scene::patch::Patch;
use glam::Vec3;
use std::f32::consts::TAU;
use std::sync::OnceLock;

/// The greatest arc of a patch: it misses the circle by less than 1e-6 of its radius.
const ARC: f32 = 30.0;

/// A piece of a profile: a cubic curve in space, and its range of v.
pub type Profile = ([Vec3; 4], [f32; 2]);

/// A straight profile.
pub fn line(a: Vec3, b: Vec3) -> Vec<Profile> {
    vec![([a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b], [0.0, 1.0])]
}

/// A circular profile about a centre (r, z) in the xz plane, from one angle to another, radians.
pub fn circle(center: [f32; 2], radius: f32, from: f32, to: f32) -> Vec<Profile> {
    // Once around is all there is.
    let to = from + (to - from).clamp(-TAU, TAU);
    let n = pieces(to - from);
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
pub fn parabola(radius: f32, z_min: f32, z_max: f32) -> Vec<Profile> {
    const PIECES: usize = 8;
    // In r the profile is of second degree; v goes with z, so that short pieces follow it.
    let r_of = |z: f32| radius * (z / z_max).max(0.0).sqrt();
    let (r0, r1) = (r_of(z_min), r_of(z_max));
    let z_of = |r: f32| z_max * (r / radius) * (r / radius);
    let r_at = |k: usize| r0 + (r1 - r0) * k as f32 / PIECES as f32;
    let v_of = |r: f32| if z_max != z_min { (z_of(r) - z_min) / (z_max - z_min) } else { 0.0 };
    (0..PIECES)
        .map(|k| {
            let (a, b) = (r_at(k), r_at(k + 1));
            let (pa, pb) = (Vec3::new(a, 0.0, z_of(a)), Vec3::new(b, 0.0, z_of(b)));
            let slope = |r: f32| Vec3::new(1.0, 0.0, 2.0 * z_max * r / (radius * radius)) * (b - a) / 3.0;
            ([pa, pa + slope(a), pb - slope(b), pb], [v_of(a), v_of(b)])
        })
        .collect()
}

fn pieces(angle: f32) -> usize {
    (angle.abs().min(TAU).to_degrees() / ARC).ceil().max(1.0) as usize
}

/// Bézier points (cosine, sine) of the unit circle's arc between two angles.
fn arc(a: f32, b: f32) -> [[f32; 2]; 4] {
    let k = 4.0 / 3.0 * ((b - a) / 4.0).tan();
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    [[ca, sa], [ca - k * sa, sa + k * ca], [cb + k * sb, sb - k * cb], [cb, sb]]
}

/// Sweep a profile about the z axis by an angle in degrees; u goes around, v along the profile.
pub fn revolve(profile: &[Profile], sweep: f32) -> Vec<Patch> {
    let turn = sweep.to_radians();
    let n = pieces(turn);
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
        revolve(&circle([0.0; 2], 1.0, -quarter, quarter), 360.0)
    })
}
