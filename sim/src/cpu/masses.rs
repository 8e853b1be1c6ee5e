//! Masses and inertia tensors of a step, in the world frame.

mod of_state;

use crate::contacts::{Arms, Contacts};
use crate::geometry::principal;
use crate::joint::Row;
use crate::twist::Twist;
use glam::{DMat3, DVec3};

/// Masses and inertia tensors in the world frame; those of bodies that do not move are infinite.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Masses {
    /// Reciprocal masses, 1/kg (n_bodies).
    pub inv_mass: Vec<f64>,
    /// Reciprocal moments of inertia of bodies with isotropic inertia, 1/(kg m²); 0 for the others (n_bodies).
    pub inv_moment: Vec<f64>,
    tensors: InertiaTensors,
    /// Bodies with isotropic inertia that were stiffened in this step, and their reciprocal moments before, 1/(kg m²).
    stiffened: Vec<(usize, f64)>,
}

/// The inertia tensors of bodies with anisotropic inertia.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
enum InertiaTensors {
    /// No bodies with anisotropic inertia.
    #[default]
    None,
    /// Slots of the bodies ([`ISOTROPIC`] for isotropic inertia; n_bodies), and the body, R J̄⁻¹ Rᵀ and its inverse by slot (n_tensors).
    Some { slot: Vec<u32>, body: Vec<u32>, tensor: Vec<[DMat3; 2]> },
}

/// The slot of a body with isotropic inertia.
const ISOTROPIC: u32 = u32::MAX;

impl Masses {
    /// Whether they may be those of `n_bodies` bodies, as a file gives them.
    pub fn are_of(&self, n_bodies: usize) -> bool {
        let is_sound =
            |numbers: &[f64]| numbers.len() == n_bodies && numbers.iter().all(|x| *x >= 0.0 && x.is_finite());
        let InertiaTensors::Some { slot, body, tensor } = &self.tensors else {
            return is_sound(&self.inv_mass) && is_sound(&self.inv_moment);
        };
        let has_tensor = |slot: &u32| *slot == ISOTROPIC || (*slot as usize) < tensor.len();
        let are_there = slot.len() == n_bodies && slot.iter().all(has_tensor) && body.len() == tensor.len();
        let are_finite = tensor.iter().flatten().all(|tensor| tensor.is_finite());
        is_sound(&self.inv_mass) && is_sound(&self.inv_moment) && are_there && are_finite
    }

    /// Undo what the last step added to isotropic inertia.
    fn unstiffen(&mut self) {
        for (b, inv_moment) in self.stiffened.drain(..).rev() {
            self.inv_moment[b] = inv_moment;
        }
    }

    /// Add to the inertia of a body for this step, kg m²; isotropic inertia stays isotropic.
    pub fn stiffen(&mut self, body: usize, added: DMat3) {
        match &mut self.tensors {
            InertiaTensors::Some { slot, tensor, .. } if slot[body] != ISOTROPIC => {
                let [inverse, inertia] = &mut tensor[slot[body] as usize];
                *inertia += added;
                *inverse = inertia.inverse();
            }
            _ => {
                let inv_moment = &mut self.inv_moment[body];
                self.stiffened.push((body, *inv_moment));
                *inv_moment = 1.0 / (1.0 / *inv_moment + principal(added).0.max_element());
            }
        }
    }

    /// Inverse inertia tensors and inertia tensors of the bodies with anisotropic inertia (n_tensors).
    pub fn tensors(&self) -> &[[DMat3; 2]] {
        match &self.tensors {
            InertiaTensors::None => &[],
            InertiaTensors::Some { tensor, .. } => tensor,
        }
    }

    /// Inverse inertia tensor and inertia tensor of a body; none if its inertia is isotropic.
    #[inline(always)]
    fn tensor(&self, body: usize) -> Option<&[DMat3; 2]> {
        match &self.tensors {
            InertiaTensors::None => None,
            InertiaTensors::Some { slot, .. } if slot[body] == ISOTROPIC => None,
            InertiaTensors::Some { slot, tensor, .. } => Some(&tensor[slot[body] as usize]),
        }
    }

    /// Whether all bodies have isotropic inertia.
    pub fn are_isotropic(&self) -> bool {
        matches!(self.tensors, InertiaTensors::None)
    }

    /// Product of a body's inverse inertia tensor and a vector.
    #[inline(always)]
    pub fn apply_inv_inertia(&self, body: usize, angular: DVec3) -> DVec3 {
        match self.tensor(body) {
            None => angular * self.inv_moment[body],
            Some([inverse, _]) => *inverse * angular,
        }
    }

    /// Change of a body's velocities by an impulse and an angular impulse. `ISOTROPIC` asserts that all bodies have isotropic inertia.
    #[inline(always)]
    pub fn change<const ISOTROPIC: bool>(&self, body: usize, impulse: &Twist) -> Twist {
        let w = if ISOTROPIC { impulse.w * self.inv_moment[body] } else { self.apply_inv_inertia(body, impulse.w) };
        Twist { v: impulse.v * self.inv_mass[body], w }
    }

    /// Twice the kinetic energy of a twist, J; 0 for a body that is held in place. `ISOTROPIC` as for [`Masses::change`].
    #[inline(always)]
    pub fn energy<const ISOTROPIC: bool>(&self, body: usize, t: &Twist) -> f64 {
        let inv_mass = self.inv_mass[body];
        if inv_mass == 0.0 {
            return 0.0;
        }
        let rotational = match if ISOTROPIC { None } else { self.tensor(body) } {
            None => t.w.length_squared() / self.inv_moment[body],
            Some([_, inertia]) => t.w.dot(*inertia * t.w),
        };
        t.v.length_squared() / inv_mass + rotational
    }

    /// Apply an impulse, N s, and an angular impulse, N m s, to a body.
    #[inline]
    pub fn apply_impulse(&self, motion: &mut [Twist], body: u32, linear: DVec3, angular: DVec3) {
        let b = body as usize;
        motion[b].v += linear * self.inv_mass[b];
        motion[b].w += self.apply_inv_inertia(b, angular);
    }

    /// Apply an impulse along a row, N s or N m s, to its two bodies.
    pub fn apply_row_impulse(&self, motion: &mut [Twist], row: &Row, impulse: f64) {
        self.apply_impulse(motion, row.bodies[0], row.linear * -impulse, row.angular_a * -impulse);
        self.apply_impulse(motion, row.bodies[1], row.linear * impulse, row.angular_b * impulse);
    }

    /// Change of a row's dΨ/dt by a unit impulse along it, 1/kg or 1/(kg m²).
    pub fn response(&self, row: &Row) -> f64 {
        let own = |b: u32, angular: DVec3| {
            let b = b as usize;
            row.linear.length_squared() * self.inv_mass[b] + self.apply_inv_inertia(b, angular).dot(angular)
        };
        own(row.bodies[0], row.angular_a) + own(row.bodies[1], row.angular_b)
    }

    /// Relative speed along the normal of contact `i` that a unit impulse along it makes, 1/kg. Arms along it have no part in it.
    #[inline]
    pub fn normal_response(&self, contacts: &Contacts, i: usize) -> f64 {
        let bodies = contacts.bodies[i].map(|b| b as usize);
        let linear = bodies.iter().map(|b| self.inv_mass[*b]).sum::<f64>();
        let Arms::Any(arms) = &contacts.arms else { return linear };
        let turns = bodies.into_iter().zip(arms[i]).map(|(b, arm)| {
            let turn = arm.cross(contacts.normal[i]);
            turn.dot(self.apply_inv_inertia(b, turn))
        });
        linear + turns.sum::<f64>()
    }

    /// Inverse inertia tensor, 1/(kg m²).
    pub fn inv_inertia(&self, body: usize) -> DMat3 {
        match self.tensor(body) {
            None => DMat3::from_diagonal(DVec3::splat(self.inv_moment[body])),
            Some([inverse, _]) => *inverse,
        }
    }

    /// Inertia tensor, kg m².
    pub fn inertia(&self, body: usize) -> DMat3 {
        match self.tensor(body) {
            None => DMat3::from_diagonal(DVec3::splat(1.0 / self.inv_moment[body])),
            Some([_, inertia]) => *inertia,
        }
    }

    /// η of contact `i`, kg: 3/trace(N_ii).
    #[inline]
    pub fn eta(&self, contacts: &Contacts, i: usize) -> f64 {
        3.0 / self.trace(contacts.bodies[i].map(|b| b as usize), contacts.arms(i))
    }

    /// trace(N_ii) of a contact between two bodies with these arms, m; 1/kg.
    #[inline]
    pub fn trace(&self, [a, b]: [usize; 2], [arm_a, arm_b]: [DVec3; 2]) -> f64 {
        let turning = self.rotational_trace(a, arm_a) + self.rotational_trace(b, arm_b);
        3.0 * (self.inv_mass[a] + self.inv_mass[b]) + turning
    }

    /// trace([a]ᵀ J⁻¹ [a]) for an arm a, m; 1/kg.
    #[inline]
    fn rotational_trace(&self, body: usize, arm: DVec3) -> f64 {
        let Some([inverse, _]) = self.tensor(body) else {
            return 2.0 * self.inv_moment[body] * arm.length_squared();
        };
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().map(|e| arm.cross(e).dot(*inverse * arm.cross(e))).sum()
    }
}
