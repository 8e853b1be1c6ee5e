//! Numbers and vectors of several contacts side by side, as straight-line code that the compiler turns into vector instructions.
//! No operation is fused: all machines get the same bits.

use super::Twist;
use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Single or double precision.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Rounded from double precision.
    fn of(x: f64) -> Self;
    /// In double precision.
    fn wide(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
}

impl Real for f32 {
    #[inline(always)]
    fn of(x: f64) -> f32 {
        x as f32
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self as f64
    }
    #[inline(always)]
    fn sqrt(self) -> f32 {
        f32::sqrt(self)
    }
}

/// A number of each of L contacts.
pub type Lane<T, const L: usize> = [T; L];

/// A vector of each of L contacts.
#[derive(Clone, Copy)]
pub struct Lane3<T, const L: usize> {
    /// x.
    pub x: Lane<T, L>,
    /// y.
    pub y: Lane<T, L>,
    /// z.
    pub z: Lane<T, L>,
}

impl<T: Real, const L: usize> Default for Lane3<T, L> {
    fn default() -> Self {
        Lane3 { x: [T::default(); L], y: [T::default(); L], z: [T::default(); L] }
    }
}

#[inline(always)]
pub fn each<T: Copy, const L: usize>(f: impl Fn(usize) -> T) -> Lane<T, L> {
    // `std::array::from_fn` is not always taken apart into vector instructions; this is.
    let mut lane = [f(0); L];
    for (l, x) in lane.iter_mut().enumerate().skip(1) {
        *x = f(l);
    }
    lane
}

impl<const L: usize> Lane3<f64, L> {
    #[inline(always)]
    pub fn load(v: [&DVec3; L]) -> Self {
        Lane3 { x: each(|l| v[l].x), y: each(|l| v[l].y), z: each(|l| v[l].z) }
    }

    /// The linear velocities of some bodies.
    #[inline(always)]
    pub fn linear(t: [&Twist; L]) -> Self {
        Lane3::load(t.map(|t| &t.v))
    }

    /// The angular velocities of some bodies.
    #[inline(always)]
    pub fn angular(t: [&Twist; L]) -> Self {
        Lane3::load(t.map(|t| &t.w))
    }
}

impl<T: Real, const L: usize> Lane3<T, L> {
    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(T, T) -> T) -> Self {
        Lane3 {
            x: each(|l| f(self.x[l], b.x[l])),
            y: each(|l| f(self.y[l], b.y[l])),
            z: each(|l| f(self.z[l], b.z[l])),
        }
    }

    #[inline(always)]
    pub fn plus(self, b: Self) -> Self {
        self.zip(b, |p, q| p + q)
    }

    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        self.zip(b, |p, q| p - q)
    }

    #[inline(always)]
    pub fn times(self, s: Lane<T, L>) -> Self {
        Lane3 { x: each(|l| self.x[l] * s[l]), y: each(|l| self.y[l] * s[l]), z: each(|l| self.z[l] * s[l]) }
    }

    #[inline(always)]
    pub fn dot(self, b: Self) -> Lane<T, L> {
        each(|l| self.x[l] * b.x[l] + self.y[l] * b.y[l] + self.z[l] * b.z[l])
    }

    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Lane3 {
            x: each(|l| self.y[l] * b.z[l] - self.z[l] * b.y[l]),
            y: each(|l| self.z[l] * b.x[l] - self.x[l] * b.z[l]),
            z: each(|l| self.x[l] * b.y[l] - self.y[l] * b.x[l]),
        }
    }

    /// Set one contact's vector.
    #[inline]
    pub fn set(&mut self, l: usize, v: DVec3) {
        (self.x[l], self.y[l], self.z[l]) = (T::of(v.x), T::of(v.y), T::of(v.z));
    }

    /// One contact's vector.
    #[inline]
    pub fn get(&self, l: usize) -> DVec3 {
        DVec3::new(self.x[l].wide(), self.y[l].wide(), self.z[l].wide())
    }
}

/// Project onto the cones |γ_t| ≤ μ γ_n, without branches.
#[inline(always)]
pub fn project<T: Real, const L: usize>(y: Lane3<T, L>, n: Lane3<T, L>, mu: Lane<T, L>) -> Lane3<T, L> {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let normal = y.dot(n);
    let tangent = y.minus(n.times(normal));
    let square = tangent.dot(tangent);
    let t: Lane<T, L> = each(|l| square[l].sqrt());
    let kept: Lane<T, L> = each(|l| {
        let kept = (t[l] * mu[l] + normal[l]) / (mu[l] * mu[l] + one);
        if t[l] * mu[l] <= -normal[l] { zero } else { kept }
    });
    let share: Lane<T, L> = each(|l| if t[l] > zero { mu[l] * kept[l] / t[l] } else { zero });
    let inside = |l: usize| t[l] <= mu[l] * normal[l];
    n.times(each(|l| if inside(l) { normal[l] } else { kept[l] }))
        .plus(tangent.times(each(|l| if inside(l) { one } else { share[l] })))
}
