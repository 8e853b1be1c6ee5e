//! Joints that hold at the end of the step: their rows are linear at its start, while its bodies move on arcs.
//!
//! What Ψ changes by over the step beyond its rate at the start goes into the rows' bias, and the joints are solved again, with the same
//! factor, until Ψ is 0 at the end. So the step is that of SHAKE: the forces of joints act in the directions of its start, the bodies move
//! freely from there, and the energy of a mechanism neither grows nor falls in the mean. One such solve, or two, would not do: what is left
//! has a sign, and energy grows by it without end (that of a slider-crank that turns by 0.18 rad in a step doubles within seconds).
//! Where solves do not come nearer, as where links turn by half a radian in a step, or a chain without slack is stiff by its compliance alone,
//! the rows stay linear for the step, by which energy is lost. So they do where the bodies on joints are light links under heavy loads. Rates that
//! motors prescribe, motors with a maximum effort, springs and geometric stiffness are always linear.
//! Source: Ryckaert, Ciccotti and Berendsen, *Numerical integration of the Cartesian equations of motion of a system with constraints* (1977).

use super::integrate::moved_pose;
use super::joint_write::Limits;
use super::masses::Masses;
use super::solve::joints::Joints;
use super::solve::response::Response;
use crate::joint::{Frames, Joint, Motor, Row};
use crate::model::Model;
use crate::pose::Pose;
use crate::rows::{fill_rows, scatter_rows};
use crate::state::State;
use crate::twist::Twist;

/// What is left of a rate Ψ/h at the end, over the speed that the row's bodies have by turning and against each other.
const LEFT: f64 = 1e-6;
/// The same without any speed, m/s or rad/s.
const ROUNDING: f64 = 1e-10;
/// The most solves: with these, most mechanisms hold that turn by up to half a radian in a step.
const MOST: usize = 30;
/// What is left over the least so far beyond which solves do not come nearer.
const FARTHER: f64 = 10.0;
/// What may be left over what shall be left, where there are no more solves.
const ENOUGH: f64 = 30.0;

/// The rows of the joints.
pub struct Linear<'a> {
    /// First row of each joint, and of the springs (n_joints + 1).
    pub start: &'a [u32],
    /// The rows, factorised.
    pub joints: &'a mut Joints,
    /// Masses and inertia tensors of the step.
    pub masses: &'a Masses,
}

/// The columns that the solves need.
#[derive(Default)]
pub struct Arcs {
    /// Poses at the end, of the bodies with rows that move (n_bodies).
    pose: Vec<Pose>,
    /// The same, side by side.
    held: Vec<Pose>,
    /// Bias of the rows on their arcs, m/s or rad/s, and what is left at the end over what may be (n_rows).
    found: Vec<[f64; 2]>,
    /// The linear rows: what they let the bodies do, and their bias.
    straight: Response,
    straight_bias: Vec<f64>,
}

impl Arcs {
    /// Prepare the rows for contacts and limits, from the velocities `free` without these and without joints, whose response goes out: the rows'
    /// bias is that of its arcs, and so are Ψ of the limits' rows.
    pub fn foresee(
        &mut self,
        (model, state): (&Model, &State),
        mut linear: Linear,
        free: &[Twist],
        (response, limits): (&mut Response, &mut Limits),
    ) {
        if !bends(&linear) {
            return;
        }
        response.twist.clear();
        response.twist.extend_from_slice(free);
        linear.joints.reset(response);
        linear.joints.solve(linear.masses, response);
        self.bend((model, state), &mut linear, response);
        let Limits { rows, joint, is_most, .. } = limits;
        for (row, (i, is_most)) in rows.iter_mut().zip(joint.iter().zip(&*is_most)) {
            let (joint, known) = (&model.joints[*i as usize], &state.joints[*i as usize]);
            let poses = joint.bodies.map(|b| end_pose(model, state, b as usize, response));
            let before = joint.coordinate(&state.joint_frames(joint), known);
            let after = joint.coordinate(&Frames::of(poses, &joint.frame_a, &joint.frame_b), known);
            let gone = if *is_most { before - after } else { after - before };
            row.psi += gone - model.step * row.speed_in(&response.twist);
        }
    }

    /// Let the joints hold at the end of the step with a response, with what else acts on their bodies.
    pub fn hold(&mut self, at: (&Model, &State), mut linear: Linear, response: &mut Response) {
        if bends(&linear) {
            self.bend(at, &mut linear, response);
        }
    }

    /// Solve until little is left, and else let the rows be linear.
    fn bend(&mut self, at: (&Model, &State), linear: &mut Linear, response: &mut Response) {
        // What turns by so little stays on its rows.
        let turns = |b: &u32| response.twist[*b as usize].w.length() * at.0.step > LEFT;
        if !linear.joints.held().iter().any(turns) {
            return;
        }
        let first = self.find(at, linear, response);
        if first <= 1.0 {
            return;
        }
        self.straight.copy_from(response);
        self.straight_bias.clone_from(&linear.joints.bias);
        let (mut left, mut least) = (first, first);
        for _ in 0..MOST {
            least = left.min(least);
            linear.joints.bias.iter_mut().zip(&self.found).for_each(|(bias, [on_arc, _])| *bias = *on_arc);
            linear.joints.solve(linear.masses, response);
            left = self.find(at, linear, response);
            if left <= 1.0 || !(left < FARTHER * least) {
                break;
            }
        }
        if !(left < ENOUGH) {
            response.copy_from(&self.straight);
            linear.joints.bias.clone_from(&self.straight_bias);
        }
    }

    /// Find the bias of the rows on the arcs of a response. Returns the greatest Ψ/h that is left of one, over what may be left.
    fn find(&mut self, (model, state): (&Model, &State), linear: &Linear, response: &Response) -> f64 {
        let (h, joints, start) = (model.step, &*linear.joints, linear.start);
        self.place(model, state, joints, response);
        let n = start[model.joints.len()] as usize;
        let (found, poses) = (&mut self.found, &self.pose);
        found.clear();
        found.extend(joints.bias[..n].iter().map(|bias| [*bias, 0.0]));
        // What is too far off comes back bit by bit.
        let farthest = model.solver.recovery_speed.max(1.0);
        scatter_rows(found, &start[..=model.joints.len()], |i, out| {
            let joint = &model.joints[i];
            if out.is_empty() {
                return;
            }
            let pose = |b: u32| if state.moves(b as usize) { poses[b as usize] } else { state.pose(b as usize) };
            let frames = Frames::of(joint.bodies.map(pose), &joint.frame_a, &joint.frame_b);
            let mut ends = Vec::with_capacity(out.len());
            joint.rows(&frames, &state.joints[i], (state.time + h, h), &mut ends);
            let first = start[i] as usize;
            for (k, (out, end)) in out.iter_mut().zip(&ends).enumerate().take(n_bent(joint, ends.len())) {
                let row = &joints.rows[first + k];
                if row.psi.abs() > farthest {
                    continue;
                }
                let [a, b] = row.bodies.map(|b| response.twist[b as usize]);
                let left = end.psi / h + joints.given(first + k, response);
                *out = [end.psi / h - row.speed(a, b), left.abs() / (LEFT * speed_of(row, a, b) + ROUNDING)];
            }
        });
        found.iter().fold(0.0, |most, [_, left]| if *left > most || left.is_nan() { *left } else { most })
    }

    /// The poses at the end of the bodies that have rows.
    fn place(&mut self, model: &Model, state: &State, joints: &Joints, response: &Response) {
        let bodies = joints.held();
        self.held.resize(bodies.len(), Pose::default());
        fill_rows(&mut self.held, |k| end_pose(model, state, bodies[k] as usize, response));
        self.pose.resize(model.n_bodies(), Pose::default());
        bodies.iter().zip(&self.held).for_each(|(b, pose)| self.pose[*b as usize] = *pose);
    }
}

/// Whether joints have rows that may bend.
fn bends(linear: &Linear) -> bool {
    let has_rows = linear.start.len() > 1 && linear.start[linear.start.len() - 1] > 0;
    has_rows && !linear.joints.is_light
}

/// The number of rows of `n` of a joint that bend: a prescribed rate is one at the start, and so is that at which a motor with a maximum effort
/// comes to its coordinate.
fn n_bent(joint: &Joint, n: usize) -> usize {
    match joint.motor {
        Some(Motor::Speed(_)) => n - 1,
        Some(Motor::Position(_)) if joint.max_effort.is_some() => n - 1,
        _ => n,
    }
}

/// The speed that two bodies have by turning, at the arms of a row, and against each other.
fn speed_of(row: &Row, a: Twist, b: Twist) -> f64 {
    let turning = row.angular_a.length() * a.w.length() + row.angular_b.length() * b.w.length();
    turning + row.linear.length() * (b.v - a.v).length()
}

fn end_pose(model: &Model, state: &State, b: usize, response: &Response) -> Pose {
    if !state.moves(b) {
        return state.pose(b);
    }
    moved_pose(&state.pose(b), &response.twist[b], model.inv_inertia[b], model.step, None).0
}
