//! Velocities at the end of the step if there were no contacts and no joints: v + h M⁻¹ f.
//! in   velocity, angular_velocity  [n_bodies]
//!      loads, motors that give an effort
//! out  masses                      [n_bodies]  in the world frame
//!      free                        [n_bodies]  m/s and rad/s, world; none where the solver makes it of the velocities
//! Source: PHYSICS, k = M v + h f. Gyroscopic terms are in `integrate`.

use super::contact_solve::Workspace;
use super::fill_rows;
use crate::joint::frames;
use crate::solve::bodies::Falling;
use crate::twist::Twist;
use crate::{Method, Model, State};
use glam::DVec3;

/// The stage. `balls` says that nothing else moves.
pub fn run(model: &Model, state: &State, balls: bool, work: &mut Workspace) {
    work.masses.turn_to(model, state);
    let (masses, free, h) = (&work.masses, &mut work.free, model.step);
    // Sweeps ask for it twice a step, which is not worth a column; iterations of the other methods do each time.
    let pushed = !(model.loads.is_empty() && model.joints.is_empty() && model.springs.is_empty());
    if balls && !pushed && model.solver.method == Method::GaussSeidel {
        *free = vec![];
        return;
    }
    free.resize(model.n_bodies(), Twist::default());
    let falling = Falling { model, state };
    fill_rows(free, |b| falling.twist(b));
    // A load acts with its mean over the step, taken in the middle.
    let middle = state.time + 0.5 * h;
    for load in &model.loads {
        let b = load.body as usize;
        if model.absent[b] {
            continue;
        }
        let vector = load.vector(middle, state.orientation[b] * model.body_frame[b].orientation);
        let (force, torque) = if load.torque {
            (DVec3::ZERO, vector)
        } else {
            (vector, (state.orientation[b] * load.point).cross(vector))
        };
        masses.push(free, load.body, force * h, torque * h);
    }
    for (i, joint) in model.joints.iter().enumerate() {
        let effort = joint.effort(middle);
        let Some(coordinate) = joint.kind.coordinate() else { continue };
        if effort == 0.0 || !joint.holds(state.time) || joint.bodies.iter().any(|b| model.absent[*b as usize]) {
            continue;
        }
        let row = joint.free_row(&frames(model, state, i), coordinate);
        masses.push_row(free, &row, effort * h);
    }
}
