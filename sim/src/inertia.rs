//! Principal moments of inertia.

use glam::{DMat3, DQuat, DVec3};

/// Inverse inertia tensor in the world frame, R J̄⁻¹ Rᵀ, 1/(kg m²).
#[inline]
pub(crate) fn world_inv_inertia(orientation: DQuat, inv_inertia: DVec3) -> DMat3 {
    if is_isotropic(inv_inertia) {
        return DMat3::from_diagonal(inv_inertia);
    }
    let r = DMat3::from_quat(orientation);
    r * DMat3::from_diagonal(inv_inertia) * r.transpose()
}

/// Whether a body's inertia is isotropic: its principal moments are equal.
#[inline]
pub(crate) fn is_isotropic(inv_inertia: DVec3) -> bool {
    inv_inertia.x == inv_inertia.y && inv_inertia.y == inv_inertia.z
}

/// Radius of gyration about an axis, m; 0 where the body does not rotate about it.
pub fn gyration(inv_mass: f64, inv_inertia: f64) -> f64 {
    if inv_inertia > 0.0 { (inv_mass / inv_inertia).sqrt() } else { 0.0 }
}
