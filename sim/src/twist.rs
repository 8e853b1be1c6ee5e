//! Linear and angular velocity, or impulse, as one.

use glam::DVec3;

/// A motion: of a body, its linear and angular velocity in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Twist {
    /// Linear, m/s.
    pub v: DVec3,
    /// Angular, rad/s.
    pub w: DVec3,
}

impl Twist {
    /// The sum of two motions.
    #[inline(always)]
    pub fn plus(&self, other: &Twist) -> Twist {
        Twist { v: self.v + other.v, w: self.w + other.w }
    }

    /// The difference of two motions.
    #[inline(always)]
    pub fn minus(&self, other: &Twist) -> Twist {
        Twist { v: self.v - other.v, w: self.w - other.w }
    }

    /// `self + β (self − from)`.
    #[inline(always)]
    pub fn beyond(&self, from: &Twist, beta: f64) -> Twist {
        Twist { v: self.v + (self.v - from.v) * beta, w: self.w + (self.w - from.w) * beta }
    }
}
