//! Write the rows of joints, motors and springs, and the limits that may be met in this step.
//! in   joints, springs            the model's
//!      position, orientation      [n_bodies]
//! out  rows                       [n_rows]    dΨ/dt and Ψ in the world frame
//!      bias                       [n_rows]    Ψ/h − rate, and what springs add, m/s
//!      limits                     [n_limits]
//! Source: paper §2, bilateral constraints; springs are implicit where they are too stiff for the step.

use crate::cpu::contact_solve::Workspace;
use crate::joint::{Coordinate, Frames, JointState, Row, frames};
use crate::{Model, State};
use glam::DVec3;

/// A limit is looked at when the coordinate may come to it within this many steps.
const LOOK_AHEAD: f64 = 3.0;

/// The stage. Joints of which a body is absent do not hold yet.
pub fn run(model: &Model, state: &State, work: &mut Workspace) {
    let h = model.step;
    let end = state.time + h;
    let (joints, limits, masses) = (&mut work.joints, &mut work.limits, &work.masses);
    work.joint_rows.clear();
    work.joint_rows.resize(model.joints.len(), 0..0);
    joints.rows.clear();
    joints.bias.clear();
    limits.clear();
    let present = |bodies: [u32; 2]| {
        !bodies.iter().any(|b| model.absent[*b as usize]) && bodies.iter().any(|b| masses.inv_mass[*b as usize] > 0.0)
    };
    for (i, joint) in model.joints.iter().enumerate() {
        if !joint.holds(state.time) || !present(joint.bodies) {
            continue;
        }
        let f = frames(model, state, i);
        let first = joints.rows.len();
        joint.rows(&f, &state.joints[i], end, &mut joints.rows);
        work.joint_rows[i] = first..joints.rows.len();
        let bound = model.solver.recovery_speed.max(1.0);
        joints.bias.extend(joints.rows[first..].iter().map(|r| (r.psi / h).clamp(-bound / h, bound / h) - r.rate));
        if let (Some([least, most]), Some(c)) = (joint.limits, joint.kind.coordinate()) {
            let at = joint.coordinate(&f, &state.joints[i]);
            let row = joint.free_row(&f, c);
            let reach = LOOK_AHEAD * h * state.joints[i].rate.abs() + near(c, most - least);
            if at - least < reach {
                limits.push(Row { psi: at - least, ..row });
            }
            if most - at < reach {
                limits.push(Row {
                    psi: most - at,
                    linear: -row.linear,
                    angular_a: -row.angular_a,
                    angular_b: -row.angular_b,
                    ..row
                });
            }
        }
    }
    for (i, spring) in model.springs.iter().enumerate() {
        if !spring.acts(state.time) || !present(spring.bodies) {
            continue;
        }
        let f = Frames::of(spring.bodies, &spring.frame_a, &spring.frame_b, state);
        let row = spring.row(&f, &state.springs[i]);
        let (k, c) = (spring.stiffness, spring.damping);
        // Explicit in position (symplectic, no numerical damping) while h²k/m is small, implicit beyond.
        let response = masses.response(&row);
        let theta = if h * h * k * response < 1.0 { 0.0 } else { 1.0 };
        let pull = k * (row.psi - spring.rest) + spring.preload.at(end);
        let damping = c + theta * h * k;
        if damping > 0.0 {
            // λ = −h (pull + damping u), or u + λ/(h damping) + pull/damping = 0.
            joints.rows.push(Row { softness: 1.0 / (h * damping), ..row });
            joints.bias.push(pull / damping);
        } else {
            masses.push_row(&mut work.free, &row, -h * pull);
        }
    }
}

/// The joints that are off most at a step's start.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointErrors {
    /// A joint and by how much a length is off, m.
    pub length: (usize, f64),
    /// A joint and by how much an angle is off, rad.
    pub angle: (usize, f64),
}

impl JointErrors {
    fn add(&mut self, joint: usize, row: &Row, error: f64) {
        let worst = if row.linear == DVec3::ZERO { &mut self.angle } else { &mut self.length };
        // An error that is not finite is the greatest.
        if !(error <= worst.1) {
            *worst = (joint, error);
        }
    }
}

/// Write what the joints and springs did: reactions, coordinates, violations. Runs before the bodies are moved.
pub fn record(model: &Model, state: &mut State, work: &mut Workspace) {
    let h = model.step;
    let motion = &work.image.twist;
    (work.joint_errors, work.spring_swing) = (JointErrors::default(), 0.0);
    for (i, joint) in model.joints.iter().enumerate() {
        let f = frames(model, state, i);
        let range = work.joint_rows[i].clone();
        let (rows, lambda) = (&work.joints.rows[range.clone()], &work.image.lambda[range]);
        let known = state.joints[i];
        let mut now = JointState { coordinate: joint.coordinate(&f, &known), ..JointState::default() };
        if let Some(c) = joint.kind.coordinate() {
            now.rate = joint.free_row(&f, c).speed_in(motion);
            now.coordinate += h * now.rate;
        }
        now.violation = rows.iter().fold(0.0, |m, r| r.psi.abs().max(m));
        for (k, row) in rows.iter().enumerate() {
            let error = joint.error(row, k, rows.len(), state.time, state.time + h);
            error.iter().for_each(|error| work.joint_errors.add(i, row, *error));
        }
        (now.force, now.torque) = f.reaction(rows, lambda, h);
        state.joints[i] = now;
    }
    for (i, spring) in model.springs.iter().enumerate() {
        let f = Frames::of(spring.bodies, &spring.frame_a, &spring.frame_b, state);
        let row = spring.row(&f, &state.springs[i]);
        let acts = spring.acts(state.time) && !spring.bodies.iter().any(|b| model.absent[*b as usize]);
        let speed = row.speed_in(motion);
        if acts {
            let pull = spring.stiffness * (row.psi - spring.rest) + spring.preload.at(state.time + h);
            work.spring_swing += (h * pull * speed).abs();
        }
        state.springs[i].coordinate = row.psi + h * speed;
        state.springs[i].force = if acts {
            spring.stiffness * (row.psi - spring.rest) + spring.damping * speed + spring.preload.at(state.time + h)
        } else {
            0.0
        };
    }
}

/// How near a limit is always looked at: a little of the range, at most 0.05 rad or 0.01 m.
fn near(coordinate: Coordinate, range: f64) -> f64 {
    let most = if coordinate == Coordinate::Angle { 0.05 } else { 0.01 };
    (0.1 * range).min(most)
}
