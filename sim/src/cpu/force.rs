//! Velocities at the step's end without contacts and joints, v + h M⁻¹ f, and the bodies' inertia tensors in the world frame.
//! in   position          [n_bodies]  m
//! in   orientation       [n_bodies]
//! in   velocity          [n_bodies]  m/s
//! in   angular_velocity  [n_bodies]  rad/s
//! in   contact_bodies    [n_contacts]  where impacts act one after another (`impacts`)
//! in   contact_normal    [n_contacts]
//! in   contact_arms      [n_contacts]  m, or
//! in   contact_reach     [n_contacts]  m
//! in   contact_gap       [n_contacts]  m
//! in   contact_law       [n_contacts]
//! out  tensor            [n_tensors] of bodies with anisotropic inertia
//! out  free              [n_bodies]  m/s and rad/s, world, where the plan has it as a column
//! Source: PHYSICS, k = M v + h f. Gyroscopic terms are in `integrate`.

use super::impacts;
use super::masses::Masses;
use super::solve::bodies::Falling;
use crate::model::Model;
use crate::plan::StepPlan;
use crate::rows::fill_rows;
use crate::state::State;
use crate::twist::Twist;

/// The stage.
pub fn run(model: &Model, plan: &StepPlan, state: &State, masses: &mut Masses, free: &mut Vec<Twist>) {
    masses.rotate(model, state);
    if !plan.has_free_column {
        // Sweeps on packed contacts read it twice a step, which is not worth a column; the other methods read it in every iteration.
        *free = vec![];
        return;
    }
    free.resize(model.n_bodies(), Twist::default());
    let falling = Falling { model, state };
    fill_rows(free, |b| falling.twist(b));
    if plan.has_sequential_impacts {
        impacts::run(model, state, masses, free);
    }
    apply(model, state, masses, free);
}

/// Let loads and efforts of motors act on the velocities.
pub fn apply(model: &Model, state: &State, masses: &Masses, free: &mut [Twist]) {
    let h = model.step;
    // A load acts with its value in the middle of the step.
    let middle = state.time + 0.5 * h;
    for load in &model.loads {
        let b = load.body as usize;
        if state.is_inactive(b) {
            continue;
        }
        let (force, torque) = load.wrench(middle, state.orientation[b], model.body_frame[b].orientation);
        masses.apply_impulse(free, load.body, force * h, torque * h);
    }
    for joint in &model.joints {
        let effort = joint.effort(middle);
        let Some(coordinate) = joint.kind.coordinate() else { continue };
        if effort == 0.0 || !joint.acts(state.time) || joint.bodies.iter().any(|b| state.is_inactive(*b as usize)) {
            continue;
        }
        let row = joint.free_row(&state.joint_frames(joint), coordinate);
        masses.apply_row_impulse(free, &row, effort * h);
    }
}
