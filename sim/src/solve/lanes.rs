//! Numbers and vectors of several contacts side by side, as straight-line code that the compiler turns into vector instructions.
//! No operation is fused: all machines get the same bits.

use super::Twist;
use glam::DVec3;

/// Contacts that go side by side.
pub const LANES: usize = 4;

/// A number of each.
pub type Lane = [f64; LANES];

/// A vector of each.
#[derive(Clone, Copy, Default)]
pub struct Lane3 {
    /// x.
    pub x: Lane,
    /// y.
    pub y: Lane,
    /// z.
    pub z: Lane,
}

#[inline(always)]
pub fn each(f: impl Fn(usize) -> f64) -> Lane {
    [f(0), f(1), f(2), f(3)]
}

/// The linear velocities of four bodies.
#[inline(always)]
pub fn linear(t: [&Twist; LANES]) -> Lane3 {
    Lane3::load([&t[0].v, &t[1].v, &t[2].v, &t[3].v])
}

/// The angular velocities of four bodies.
#[inline(always)]
pub fn angular(t: [&Twist; LANES]) -> Lane3 {
    Lane3::load([&t[0].w, &t[1].w, &t[2].w, &t[3].w])
}

impl Lane3 {
    #[inline(always)]
    pub fn load(v: [&DVec3; LANES]) -> Lane3 {
        Lane3 { x: each(|l| v[l].x), y: each(|l| v[l].y), z: each(|l| v[l].z) }
    }

    #[inline(always)]
    fn zip(self, b: Lane3, f: impl Fn(f64, f64) -> f64) -> Lane3 {
        Lane3 {
            x: each(|l| f(self.x[l], b.x[l])),
            y: each(|l| f(self.y[l], b.y[l])),
            z: each(|l| f(self.z[l], b.z[l])),
        }
    }

    #[inline(always)]
    pub fn plus(self, b: Lane3) -> Lane3 {
        self.zip(b, |p, q| p + q)
    }

    #[inline(always)]
    pub fn minus(self, b: Lane3) -> Lane3 {
        self.zip(b, |p, q| p - q)
    }

    #[inline(always)]
    pub fn times(self, s: Lane) -> Lane3 {
        Lane3 { x: each(|l| self.x[l] * s[l]), y: each(|l| self.y[l] * s[l]), z: each(|l| self.z[l] * s[l]) }
    }

    #[inline(always)]
    pub fn dot(self, b: Lane3) -> Lane {
        each(|l| self.x[l] * b.x[l] + self.y[l] * b.y[l] + self.z[l] * b.z[l])
    }

    #[inline(always)]
    pub fn cross(self, b: Lane3) -> Lane3 {
        Lane3 {
            x: each(|l| self.y[l] * b.z[l] - self.z[l] * b.y[l]),
            y: each(|l| self.z[l] * b.x[l] - self.x[l] * b.z[l]),
            z: each(|l| self.x[l] * b.y[l] - self.y[l] * b.x[l]),
        }
    }
}

/// Project onto the cones |γ_t| ≤ μ γ_n, without branches.
#[inline(always)]
pub fn project(y: Lane3, n: Lane3, mu: Lane) -> Lane3 {
    let normal = y.dot(n);
    let tangent = y.minus(n.times(normal));
    let square = tangent.dot(tangent);
    let t = each(|l| square[l].sqrt());
    let pick = |l: usize| {
        let inside = t[l] <= mu[l] * normal[l];
        let polar = t[l] * mu[l] <= -normal[l];
        let kept = (t[l] * mu[l] + normal[l]) / (mu[l] * mu[l] + 1.0);
        let kept = if polar { 0.0 } else { kept };
        let share = if t[l] > 0.0 { mu[l] * kept / t[l] } else { 0.0 };
        (if inside { normal[l] } else { kept }, if inside { 1.0 } else { share })
    };
    let picked = [pick(0), pick(1), pick(2), pick(3)];
    n.times(each(|l| picked[l].0)).plus(tangent.times(each(|l| picked[l].1)))
}
