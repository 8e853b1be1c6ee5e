//! The cone of Lorentz, x_n ≥ |x_t|, as interior point methods need it: its Jordan product, the scaling of Nesterov and Todd, and how
//! far a direction stays within.

use glam::{DMat3, DVec3};

/// The scaling W of Nesterov and Todd of one contact: W z = W⁻¹ s.
#[derive(Clone, Copy, Default)]
pub struct Scaling {
    w: DVec3,
    beta: f64,
}

impl Scaling {
    /// The scaling of a pair within the cone.
    pub fn new(z: DVec3, s: DVec3) -> Scaling {
        let (dz, ds) = (determinant(z), determinant(s));
        let (z, s) = (z / dz.sqrt(), s / ds.sqrt());
        let half = (0.5 * (1.0 + z.dot(s))).sqrt();
        Scaling { w: (s + DVec3::new(z.x, -z.y, -z.z)) / (2.0 * half), beta: (ds / dz).sqrt().sqrt() }
    }

    /// W x.
    pub fn apply(&self, x: DVec3) -> DVec3 {
        boost(self.w, x) * self.beta
    }

    /// W⁻¹ x.
    pub fn apply_inverse(&self, x: DVec3) -> DVec3 {
        boost(DVec3::new(self.w.x, -self.w.y, -self.w.z), x) / self.beta
    }

    /// W².
    pub fn square(&self) -> DMat3 {
        let w = self.w;
        let outer = DMat3::from_cols(w * w.x, w * w.y, w * w.z) * 2.0;
        (outer + DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))) * (self.beta * self.beta)
    }
}

/// Multiply by the symmetric root of 2 w wᵀ − J.
fn boost(w: DVec3, x: DVec3) -> DVec3 {
    let dot = w.y * x.y + w.z * x.z;
    let along = x.x + dot / (w.x + 1.0);
    DVec3::new(w.x * x.x + dot, x.y + w.y * along, x.z + w.z * along)
}

/// x_n² − |x_t|² of a vector in the cone.
fn determinant(x: DVec3) -> f64 {
    let t = (x.y * x.y + x.z * x.z).sqrt();
    ((x.x - t) * (x.x + t)).max(f64::MIN_POSITIVE)
}

/// The product of the cone's Jordan algebra.
pub fn product(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.dot(b), a.x * b.y + b.x * a.y, a.x * b.z + b.x * a.z)
}

/// The x whose product with l is u.
pub fn quotient(l: DVec3, u: DVec3) -> DVec3 {
    let d = determinant(l);
    let x = (l.x * u.x - l.y * u.y - l.z * u.z) / d;
    DVec3::new(x, (u.y - l.y * x) / l.x, (u.z - l.z * x) / l.x)
}

/// The largest t for which x + t d is in the cone.
pub fn longest(x: DVec3, d: DVec3) -> f64 {
    let length = (d.y * d.y + d.z * d.z).sqrt();
    let (a, b) = ((d.x - length) * (d.x + length), x.x * d.x - x.y * d.y - x.z * d.z);
    let c = determinant(x);
    let root = (b * b - a * c).max(0.0).sqrt();
    let first = |t: f64| if t > 0.0 { t } else { f64::INFINITY };
    let quadratic = if b * b < a * c { f64::INFINITY } else { first(c / (root - b)).min(first(c / (-b - root))) };
    if d.x < 0.0 { quadratic.min(-x.x / d.x) } else { quadratic }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::SplitMix64;

    /// Vectors within the cone, some of them near its edge, and any vectors.
    fn cases() -> Vec<[DVec3; 3]> {
        let mut random = SplitMix64(7);
        let mut vector = || DVec3::from([(); 3].map(|()| random.between(-1.0, 1.0)));
        let inside = |v: DVec3, room: f64| DVec3::new(v.y.hypot(v.z) + room * (1.0 + v.x), v.y, v.z);
        (0..100).map(|k| [inside(vector(), 10f64.powi(-(k % 5))), inside(vector(), 0.5), vector()]).collect()
    }

    #[test]
    fn the_scaling_maps_z_to_what_its_inverse_makes_of_s() {
        for [z, s, x] in cases() {
            let w = Scaling::new(z, s);
            // W² z = s, and W² is W twice.
            assert!((w.square() * z - s).length() < 1e-9 * s.length(), "{z} {s}");
            assert!((w.apply(w.apply(x)) - w.square() * x).length() < 1e-9 * (w.square() * x).length(), "{z} {s}");
            assert!((w.apply_inverse(w.apply(x)) - x).length() < 1e-6, "{z} {s}");
        }
    }

    #[test]
    fn the_quotient_undoes_the_product() {
        for [l, _, x] in cases() {
            assert!((quotient(l, product(l, x)) - x).length() < 1e-9, "{l} {x}");
        }
    }

    #[test]
    fn the_longest_step_ends_on_the_edge() {
        for [x, _, d] in cases() {
            let t = longest(x, d);
            let edge = |v: DVec3| v.x - v.y.hypot(v.z);
            if t.is_finite() {
                assert!(edge(x + d * t).abs() < 1e-7 * (x + d * t).length(), "{x} {d} {t}");
            }
            let near = t.min(1e6) * 0.999;
            assert!(edge(x + d * near) > 0.0, "{x} {d} {t}");
        }
    }
}
