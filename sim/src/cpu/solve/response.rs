//! The response to impulses: velocities and joint multipliers.

use crate::rows::fill_rows;
use crate::twist::Twist;
use glam::DVec3;

/// The response of multipliers γ: velocities of all bodies, and the joints' multipliers. Linear combinations of it are cheap.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// Velocities of the bodies, world (n_bodies).
    pub twist: Vec<Twist>,
    /// Multipliers of the eliminated joint rows (n_rows).
    pub lambda: Vec<f64>,
}

impl Response {
    /// `self = a + β (a − b)`.
    pub fn extrapolate(&mut self, a: &Response, b: &Response, beta: f64) {
        self.twist.resize(a.twist.len(), Twist::default());
        fill_rows(&mut self.twist, |i| a.twist[i].beyond(&b.twist[i], beta));
        self.lambda.clear();
        self.lambda.extend(a.lambda.iter().zip(&b.lambda).map(|(p, q)| p + (p - q) * beta));
    }

    pub fn copy_from(&mut self, other: &Response) {
        self.twist.clone_from(&other.twist);
        self.lambda.clone_from(&other.lambda);
    }
}

/// The point y = x + β (x − previous), with its response.
#[derive(Clone, Copy)]
pub struct Extrapolated<'a> {
    /// x.
    pub x: &'a [DVec3],
    /// The point before x.
    pub previous: &'a [DVec3],
    /// β.
    pub beta: f64,
    /// The response of y.
    pub response: &'a Response,
}
