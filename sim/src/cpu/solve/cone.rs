//! Friction cones.

use glam::DVec3;

/// Project onto the cone |γ_t| ≤ μ γ_n about the axis n.
#[inline]
pub fn project_cone(y: DVec3, n: DVec3, mu: f64) -> DVec3 {
    let normal = y.dot(n);
    let tangent = y - n * normal;
    let t2 = tangent.length_squared();
    if normal >= 0.0 && t2 <= mu * mu * normal * normal {
        return y;
    }
    let t = t2.sqrt();
    if t * mu <= -normal {
        return DVec3::ZERO;
    }
    let kept = (t * mu + normal) / (mu * mu + 1.0);
    n * kept + tangent * (mu * kept / t)
}
