//! Move the bodies with their new velocities.
//! in    linear, angular             [n_bodies]  m/s and rad/s, world, after the solver
//! inout position, orientation       [n_bodies]
//! out   velocity, angular_velocity  [n_bodies]  m/s world, rad/s body frame
//! Source: PHYSICS, q⁺ = q + h L(q) v⁺; the rotation over a step is taken exactly, and the angular momentum of the world
//! frame is carried over it, so that a free body keeps it to round-off.

use super::fill_rows;
use crate::{Model, State};
use glam::{DQuat, DVec3};

/// The stage.
pub fn run(model: &Model, linear: &[DVec3], angular: &[DVec3], state: &mut State) {
    let h = model.step;
    let moves = |b: usize| model.inv_mass[b] > 0.0;
    let turned = |b: usize, from: DQuat| (DQuat::from_scaled_axis(angular[b] * h) * from).normalize();
    let (position, orientation) = (std::mem::take(&mut state.position), std::mem::take(&mut state.orientation));
    let mut next_position = position.clone();
    fill_rows(&mut next_position, |b| if moves(b) { position[b] + linear[b] * h } else { position[b] });
    fill_rows(&mut state.velocity, |b| if moves(b) { linear[b] } else { DVec3::ZERO });
    fill_rows(&mut state.angular_velocity, |b| {
        if !moves(b) {
            return DVec3::ZERO;
        }
        let momentum = orientation[b] * ((orientation[b].inverse() * angular[b]) / model.inv_inertia[b]);
        (turned(b, orientation[b]).inverse() * momentum) * model.inv_inertia[b]
    });
    let mut next_orientation = orientation.clone();
    fill_rows(&mut next_orientation, |b| if moves(b) { turned(b, orientation[b]) } else { orientation[b] });
    state.position = next_position;
    state.orientation = next_orientation;
    state.steps += 1;
    state.time = state.steps as f64 * h;
}
