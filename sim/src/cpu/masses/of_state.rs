//! The masses of the bodies of a state: of those that move, in their orientations.

use super::{ISOTROPIC, InertiaTensors, Masses};
use crate::geometry::principal;
use crate::inertia::{is_isotropic, world_inv_inertia};
use crate::model::Model;
use crate::rows::fill_rows;
use crate::state::State;
use glam::{DMat3, DQuat, DVec3};

/// The inverse inertia tensor of a body, 1/(kg m²), and the inertia tensor, kg m², in its orientation.
fn rotated(model: &Model, state: &State, body: usize) -> [DMat3; 2] {
    let of = |inv_inertia: DVec3| world_inv_inertia(state.orientation[body], inv_inertia);
    [of(model.inv_inertia[body]), of(model.inv_inertia[body].recip())]
}

impl Masses {
    /// Take the masses and principal moments of the bodies that move.
    pub fn prepare(&mut self, model: &Model, state: &State) {
        let n = model.n_bodies();
        self.inv_mass.clear();
        self.inv_mass.extend((0..n).map(|b| if state.moves(b) { model.inv_mass[b] } else { 0.0 }));
        let isotropic = |b: usize| !state.moves(b) || is_isotropic(model.inv_inertia[b]);
        self.stiffened.clear();
        self.inv_moment.clear();
        self.inv_moment
            .extend((0..n).map(|b| if state.moves(b) && isotropic(b) { model.inv_inertia[b].x } else { 0.0 }));
        let body: Vec<u32> = (0..n as u32).filter(|b| !isotropic(*b as usize)).collect();
        let mut slot = vec![ISOTROPIC; n];
        body.iter().zip(0..).for_each(|(b, k)| slot[*b as usize] = k);
        self.tensors = match body.len() {
            0 => InertiaTensors::None,
            n => InertiaTensors::Some { slot, body, tensor: vec![[DMat3::ZERO; 2]; n] },
        };
    }

    /// Rotate the inertia tensors to the bodies' orientations.
    pub fn rotate(&mut self, model: &Model, state: &State) {
        self.unstiffen();
        if let InertiaTensors::Some { body, tensor, .. } = &mut self.tensors {
            fill_rows(tensor, |k| rotated(model, state, body[k] as usize));
        }
    }

    /// [`Masses::rotate`] of some bodies: all that are asked for in the step.
    pub fn rotate_bodies(&mut self, model: &Model, state: &State, bodies: impl Iterator<Item = usize>) {
        self.unstiffen();
        let InertiaTensors::Some { slot, tensor, .. } = &mut self.tensors else { return };
        for b in bodies.filter(|b| slot[*b] != ISOTROPIC) {
            tensor[slot[b] as usize] = rotated(model, state, b);
        }
    }

    /// Inverse principal moments, 1/(kg m²), and principal frame of the inertia that a body has in this step.
    pub fn principal(&self, model: &Model, state: &State, body: usize) -> (DVec3, DQuat) {
        let (inverse, orientation) = (model.inv_inertia[body], state.orientation[body]);
        let now = self.inv_inertia(body);
        if !state.moves(body) || now == world_inv_inertia(orientation, inverse) {
            return (inverse, orientation);
        }
        let (values, axes) = principal(self.inertia(body));
        (values.recip(), axes)
    }
}
