//! The work of what drives a model: motors, actuators, loads, and preloads of springs that change.
//!
//! An impulse p along a row with the Jacobian J does the work p J (v + v⁺)/2 in a step that begins with the velocities v and ends with v⁺.
//! Since M (v⁺ − v) is the sum of all Jᵀ p, the work of all of them, those of gravity, contacts and locked rows too, is the change of
//! kinetic energy without an error of time stepping. So what a model has more than the work that it was given comes from nowhere
//! ([`crate::watch`]).

use crate::inertia::gyration;
use crate::joint::{Coordinate, Joint, JointState, Row};
use crate::load::Load;
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;
use glam::DQuat;

/// The velocities before a step, of a state, and after it (n_bodies).
#[derive(Clone, Copy)]
pub struct Span<'a> {
    /// The state at the step's start.
    pub state: &'a State,
    /// Velocities at its end.
    pub motion: &'a [Twist],
}

impl Span<'_> {
    /// Mean dΨ/dt of a row in the step, m/s or rad/s.
    pub fn mean_speed(&self, row: &Row) -> f64 {
        let [a, b] = row.bodies.map(|b| self.before(b as usize));
        0.5 * (row.speed(a, b) + row.speed_in(self.motion))
    }

    /// Work of the loads in the step, J, each alone.
    pub fn of_loads(&self, model: &Model) -> impl Iterator<Item = f64> {
        model.loads.iter().map(move |load| {
            let b = load.body as usize;
            if !self.state.moves(b) {
                return 0.0;
            }
            let (middle, frame) = (self.state.time + 0.5 * model.step, model.body_frame[b].orientation);
            let (force, torque) = load.wrench(middle, self.state.orientation[b], frame);
            let [before, after] = [self.before(b), self.motion[b]];
            0.5 * model.step * (force.dot(before.v + after.v) + torque.dot(before.w + after.w))
        })
    }

    fn before(&self, body: usize) -> Twist {
        if self.state.moves(body) { self.state.twist(body) } else { Twist::default() }
    }
}

/// Work of a spring's preload as it changes in the step that begins now, J.
pub fn of_preload(model: &Model, state: &State, id: usize) -> f64 {
    let spring = &model.springs[id];
    let change = spring.preload.at(state.time + model.step) - spring.preload.at(state.time);
    change * (state.springs[id].coordinate - spring.rest)
}

/// Sum of the forces that drive a model, N, after a step: those of motors and loads, torques over the least radius of gyration.
pub fn forces(model: &Model, state: &State) -> f64 {
    let least = |bodies: &[u32]| {
        let moving = bodies.iter().map(|b| *b as usize).filter(|b| model.inv_mass[*b] > 0.0);
        let sizes = moving.map(|b| gyration(model.inv_mass[b], model.inv_inertia[b].max_element()));
        sizes.filter(|size| *size > 0.0).fold(f64::INFINITY, f64::min)
    };
    let of_joint = |(joint, now): (&Joint, &JointState)| match joint.kind.coordinate() {
        Some(Coordinate::Angle) if now.effort != 0.0 => now.effort.abs() / least(&joint.bodies),
        _ => now.effort.abs(),
    };
    let of_load = |load: &Load| {
        let value = load.vector(state.time - 0.5 * model.step, DQuat::IDENTITY).length();
        if load.torque { value / least(&[load.body]) } else { value }
    };
    let of_joints: f64 = model.joints.iter().zip(&state.joints).map(of_joint).sum();
    of_joints + model.loads.iter().map(of_load).sum::<f64>()
}
