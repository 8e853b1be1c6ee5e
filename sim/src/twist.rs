//! Twists: linear and angular velocity, or impulse, of a body.

use glam::DVec3;

/// The twist of a body: linear and angular part of a velocity, or of an impulse, about the centre of mass in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Twist {
    /// Linear part, m/s or N s.
    pub v: DVec3,
    /// Angular part, rad/s or N m s.
    pub w: DVec3,
}

impl Twist {
    /// The sum of two twists.
    #[inline(always)]
    pub fn plus(&self, other: &Twist) -> Twist {
        Twist { v: self.v + other.v, w: self.w + other.w }
    }

    /// The difference of two twists.
    #[inline(always)]
    pub fn minus(&self, other: &Twist) -> Twist {
        Twist { v: self.v - other.v, w: self.w - other.w }
    }

    /// The product with a number.
    #[inline(always)]
    pub fn times(&self, factor: f64) -> Twist {
        Twist { v: self.v * factor, w: self.w * factor }
    }

    /// The extrapolation `self + β (self − from)`.
    #[inline(always)]
    pub fn beyond(&self, from: &Twist, beta: f64) -> Twist {
        Twist { v: self.v + (self.v - from.v) * beta, w: self.w + (self.w - from.w) * beta }
    }
}
