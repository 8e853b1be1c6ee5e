//! Masses and moments of inertia in the world frame, as they are in a step.

use crate::inertia::{is_isotropic, world_inv_inertia};
use crate::joint::Row;
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;
use glam::{DMat3, DVec3};

/// Masses and moments of inertia in the world frame; those of bodies that do not move are infinite.
#[derive(Default)]
pub struct Masses {
    /// Reciprocal masses, 1/kg (n_bodies).
    pub inv_mass: Vec<f64>,
    /// Reciprocal moments of inertia of bodies that turn alike about all axes, 1/(kg m²); 0 for the others (n_bodies).
    pub inv_moment: Vec<f64>,
    tensors: Tensors,
}

/// The moments of inertia of bodies that do not turn alike about all axes.
#[derive(Default)]
enum Tensors {
    /// There are no such bodies.
    #[default]
    None,
    /// R J̄⁻¹ Rᵀ and its inverse, at the body's slot ([`ISOTROPIC`] for those that turn alike; n_bodies).
    Some { slot: Vec<u32>, tensor: Vec<[DMat3; 2]> },
}

/// The slot of a body that turns alike about all axes.
const ISOTROPIC: u32 = u32::MAX;

impl Masses {
    /// Take up which bodies move.
    pub fn prepare(&mut self, model: &Model, state: &State) {
        let n = model.n_bodies();
        self.inv_mass.clear();
        self.inv_mass.extend((0..n).map(|b| if state.moves(b) { model.inv_mass[b] } else { 0.0 }));
        let isotropic = |b: usize| !state.moves(b) || is_isotropic(model.inv_inertia[b]);
        self.inv_moment.clear();
        self.inv_moment
            .extend((0..n).map(|b| if state.moves(b) && isotropic(b) { model.inv_inertia[b].x } else { 0.0 }));
        let mut n_tensors = 0;
        let slot: Vec<u32> =
            (0..n).map(|b| if isotropic(b) { ISOTROPIC } else { (n_tensors, n_tensors += 1).0 }).collect();
        self.tensors = match n_tensors {
            0 => Tensors::None,
            n => Tensors::Some { slot, tensor: vec![[DMat3::ZERO; 2]; n as usize] },
        };
    }

    /// Turn the moments of inertia to where the bodies are.
    pub fn turn_to(&mut self, model: &Model, state: &State) {
        let Tensors::Some { slot, tensor } = &mut self.tensors else { return };
        for (b, slot) in slot.iter().enumerate().filter(|(_, s)| **s != ISOTROPIC) {
            let of = |inv_inertia: DVec3| world_inv_inertia(state.orientation[b], inv_inertia);
            tensor[*slot as usize] = [of(model.inv_inertia[b]), of(model.inv_inertia[b].recip())];
        }
    }

    /// The tensors of all bodies that do not turn alike about all axes (n_tensors).
    pub fn tensors(&self) -> &[[DMat3; 2]] {
        match &self.tensors {
            Tensors::None => &[],
            Tensors::Some { tensor, .. } => tensor,
        }
    }

    /// The tensors of a body that does not turn alike about all axes.
    #[inline(always)]
    fn tensor(&self, body: usize) -> Option<&[DMat3; 2]> {
        match &self.tensors {
            Tensors::None => None,
            Tensors::Some { slot, .. } if slot[body] == ISOTROPIC => None,
            Tensors::Some { slot, tensor } => Some(&tensor[slot[body] as usize]),
        }
    }

    /// Whether all bodies turn alike about all axes.
    pub fn are_isotropic(&self) -> bool {
        matches!(self.tensors, Tensors::None)
    }

    /// Reciprocal inertia times a vector.
    #[inline(always)]
    pub fn turn(&self, body: usize, angular: DVec3) -> DVec3 {
        match self.tensor(body) {
            None => angular * self.inv_moment[body],
            Some([inverse, _]) => *inverse * angular,
        }
    }

    /// The change of a body's velocities by an impulse and an angular impulse. `ISOTROPIC` says that all bodies turn alike about all
    /// axes, so that nothing is asked for each.
    #[inline(always)]
    pub fn change<const ISOTROPIC: bool>(&self, body: usize, impulse: &Twist) -> Twist {
        let w = if ISOTROPIC { impulse.w * self.inv_moment[body] } else { self.turn(body, impulse.w) };
        Twist { v: impulse.v * self.inv_mass[body], w }
    }

    /// Twice the kinetic energy of a motion, J; 0 for a body that is held in place. `ISOTROPIC` as for [`Masses::change`].
    #[inline(always)]
    pub fn energy<const ISOTROPIC: bool>(&self, body: usize, t: &Twist) -> f64 {
        let inv_mass = self.inv_mass[body];
        if inv_mass == 0.0 {
            return 0.0;
        }
        let turning = match if ISOTROPIC { None } else { self.tensor(body) } {
            None => t.w.length_squared() / self.inv_moment[body],
            Some([_, inertia]) => t.w.dot(*inertia * t.w),
        };
        t.v.length_squared() / inv_mass + turning
    }

    /// Give a body an impulse, N s, and an angular impulse, N m s.
    #[inline]
    pub fn push(&self, motion: &mut [Twist], body: u32, linear: DVec3, angular: DVec3) {
        let b = body as usize;
        motion[b].v += linear * self.inv_mass[b];
        motion[b].w += self.turn(b, angular);
    }

    /// Give the two bodies of a row an impulse along it.
    pub fn push_row(&self, motion: &mut [Twist], row: &Row, impulse: f64) {
        self.push(motion, row.bodies[0], row.linear * -impulse, row.angular_a * -impulse);
        self.push(motion, row.bodies[1], row.linear * impulse, row.angular_b * impulse);
    }

    /// The change of a row's speed by a unit impulse along it, 1/kg.
    pub fn response(&self, row: &Row) -> f64 {
        let own = |b: u32, angular: DVec3| {
            let b = b as usize;
            row.linear.length_squared() * self.inv_mass[b] + self.turn(b, angular).dot(angular)
        };
        own(row.bodies[0], row.angular_a) + own(row.bodies[1], row.angular_b)
    }

    /// Reciprocal inertia.
    pub fn inv_inertia(&self, body: usize) -> DMat3 {
        match self.tensor(body) {
            None => DMat3::from_diagonal(DVec3::splat(self.inv_moment[body])),
            Some([inverse, _]) => *inverse,
        }
    }

    /// trace([a]ᵀ J⁻¹ [a]) for an arm a.
    #[inline]
    pub fn turning_trace(&self, body: usize, arm: DVec3) -> f64 {
        let Some([inverse, _]) = self.tensor(body) else {
            return 2.0 * self.inv_moment[body] * arm.length_squared();
        };
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().map(|e| arm.cross(e).dot(*inverse * arm.cross(e))).sum()
    }
}
