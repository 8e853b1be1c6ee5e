//! Joints that hold at the end of the step: their rows are linear at its start, while its bodies move on arcs.
//!
//! What Ψ changes by over the step beyond its rate at the start goes into the rows' bias, and the joints are solved again, with the same
//! factor, until Ψ is 0 at the end. So the step is that of SHAKE: the forces of joints act in the directions of its start, the bodies move
//! freely from there, and the energy of a mechanism neither grows nor falls in the mean. One such solve, or two, would not do: what is left
//! has a sign, and energy grows by it without end (that of a slider-crank that turns by 0.18 rad in a step doubles within seconds).
//! A step that bends too much for this is taken in parts ([`crate::pace`]). Where solves do not come nearer all the same, or where nothing turns, as
//! in a chain without slack, which is stiff by its compliance alone, the rows stay linear for the step, by which energy is lost. So they do where the
//! bodies on joints are light links under heavy loads. Rates that motors prescribe, motors with a maximum effort, springs and geometric stiffness are always linear.
//! Source: Ryckaert, Ciccotti and Berendsen, *Numerical integration of the Cartesian equations of motion of a system with constraints* (1977).

use super::integrate::moved_pose;
use super::masses::Masses;
use super::solve::joints::Joints;
use super::solve::limits::Limit;
use super::solve::response::Response;
use crate::inertia::gyration;
use crate::joint::{Coordinate, Frames, Joint, Motor};
use crate::model::Model;
use crate::pace::Bend;
use crate::pose::Pose;
use crate::rows::{fill_rows, scatter_rows};
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;

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
/// Turn of a body in a step below which its rows are straight, rad.
const TURNS: f64 = 1e-3;

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
    /// Bias of the rows on their arcs, m/s or rad/s, what is left at the end over what may be, the same over the speed of bodies that turn, and
    /// the work of the row's force on it, J (n_rows).
    found: Vec<[f64; 4]>,
    /// Work of the forces on what is left, and kinetic energy, J (n_held, at the numbers of mechanisms).
    energy: Vec<[f64; 2]>,
    /// The linear rows: what they let the bodies do, and their bias.
    straight: Response,
    straight_bias: Vec<f64>,
    /// What the joints bend in this step.
    pub bend: Bend,
    /// How far bodies on joints turn in it, rad.
    pub turn: f64,
}

impl Arcs {
    /// Prepare the rows for contacts, from the velocities `free` without these and without joints, whose response goes out: the rows' bias is that of
    /// its arcs.
    pub fn foresee(&mut self, at: (&Model, &State), mut linear: Linear, free: &[Twist], response: &mut Response) {
        if !bends(&linear) {
            return;
        }
        response.twist.clear();
        response.twist.extend_from_slice(free);
        linear.joints.reset(response);
        linear.joints.solve(linear.masses, response);
        self.bend(at, &mut linear, response);
    }

    /// Let the joints hold at the end of the step with a response, with what else acts on their bodies.
    pub fn hold(&mut self, at: (&Model, &State), mut linear: Linear, response: &mut Response) {
        // The strain without contacts, where there are any, does not matter.
        (self.turn, self.bend.strain) = (0.0, 0.0);
        if bends(&linear) {
            self.bend(at, &mut linear, response);
        } else {
            linear.joints.finish(linear.masses, response);
        }
    }

    /// Solve until little is left, and else let the rows be linear.
    fn bend(&mut self, at: (&Model, &State), linear: &mut Linear, response: &mut Response) {
        let is_on_arcs = self.bend_rows(at, linear, response);
        let (model, state) = at;
        let Linear { joints, .. } = linear;
        for limit in joints.limits.iter_mut() {
            let (joint, known) = (&model.joints[limit.joint as usize], &state.joints[limit.joint as usize]);
            let row = &joints.rows[limit.row as usize];
            let poses = joint.bodies.map(|b| end_pose(model, state, b as usize, response));
            let end = joint.coordinate(&Frames::of(poses, &joint.frame_a, &joint.frame_b), known);
            let gone = joint.room(end, limit.is_most) - row.psi;
            limit.curve = if is_on_arcs { gone / model.step - row.speed_in(&response.twist) } else { 0.0 };
        }
    }

    /// [`Arcs::bend`] of the rows. Returns whether what holds does so on its arcs.
    fn bend_rows(&mut self, at: (&Model, &State), linear: &mut Linear, response: &mut Response) -> bool {
        // What turns by so little stays on its rows.
        let [turn, change] = turning(at, linear, response);
        self.turn = turn;
        if turn <= LEFT {
            linear.joints.finish(linear.masses, response);
            return true;
        }
        let first = self.find(at, linear, response);
        let bent = self.found.iter().fold(0.0f64, |most, [_, _, bent, _]| most.max(*bent));
        if first <= 1.0 {
            return true;
        }
        let strain = self.strain(at.0, linear, response);
        self.straight.copy_from(response);
        self.straight_bias.clone_from(&linear.joints.bias);
        let was_old = linear.joints.is_old();
        let (mut left, mut least) = (first, first);
        for _ in 0..MOST {
            least = left.min(least);
            let before = left;
            linear.joints.bias.iter_mut().zip(&self.found).for_each(|(bias, [on_arc, ..])| *bias = *on_arc);
            linear.joints.solve(linear.masses, response);
            left = self.find(at, linear, response);
            if left <= 1.0 {
                break;
            }
            if !linear.joints.renew_if_slow(linear.masses, left, before) && !(left < FARTHER * least) {
                break;
            }
        }
        let is_lost = !(left < ENOUGH);
        self.bend = self.bend.and(Bend { turn, bent, change, strain, is_lost });
        if is_lost {
            response.copy_from(&self.straight);
            linear.joints.bias.clone_from(&self.straight_bias);
            if was_old {
                linear.joints.solve(linear.masses, response);
                linear.joints.finish(linear.masses, response);
            }
        }
        !is_lost
    }

    /// Find the bias of the rows on the arcs of a response. Returns the greatest Ψ/h that is left of one, over what may be left.
    fn find(&mut self, (model, state): (&Model, &State), linear: &Linear, response: &Response) -> f64 {
        let (h, joints, start) = (model.step, &*linear.joints, linear.start);
        self.place(model, state, joints, response);
        let n = start[model.joints.len()] as usize;
        let (found, poses) = (&mut self.found, &self.pose);
        found.clear();
        found.extend(joints.bias[..n].iter().map(|bias| [*bias, 0.0, 0.0, 0.0]));
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
            let limits = joints.limits.of_joint(i as u32);
            let n_own = out.len() - limits.len();
            let rows = ends.iter().take(n_bent(joint, n_own)).map(|end| end.psi).enumerate();
            let room = |limit: &Limit| joint.room(joint.coordinate(&frames, &state.joints[i]), limit.is_most);
            let held = limits.iter().filter(|limit| limit.is_held);
            let rows = rows.chain(held.map(|limit| (limit.row as usize - first, room(limit))));
            let has_length = has_length(joint, limits);
            // Of lengths and of angles: a row along an arm has no speed by its turning.
            let [mut lefts, mut speeds] = [[0.0f64; 2]; 2];
            for (k, end) in rows {
                let row = &joints.rows[first + k];
                if row.psi.abs() > farthest {
                    continue;
                }
                let [a, b] = row.bodies.map(|b| response.twist[b as usize]);
                let rate = (end - joints.kept[first + k]) / h;
                let left = rate + joints.given(first + k, response);
                let speed = row.speeds(a, b);
                let turns = has_length || a.w.length().max(b.w.length()) * h > TURNS;
                let work = (left * response.lambda[first + k]).abs();
                out[k] = [rate - row.speed(a, b), left.abs() / (LEFT * speed + ROUNDING), 0.0, work];
                let kind = usize::from(row.linear == DVec3::ZERO);
                if turns {
                    (lefts[kind], speeds[kind]) = (left.abs().max(lefts[kind]), speed.max(speeds[kind]));
                    if kind == 0 {
                        // A wheel that carries its axle at its centre has no speed there.
                        let spins = [0, 1].map(|k| spin_speed(model, row.bodies[k], [a, b][k]));
                        speeds[0] = spins[0].max(spins[1]).max(speeds[0]);
                    }
                }
            }
            let bent = |k: usize| lefts[k] / (speeds[k] + ROUNDING);
            out[0][2] = bent(0).max(bent(1));
        });
        found.iter().fold(0.0, |most, [_, left, ..]| if *left > most || left.is_nan() { *left } else { most })
    }

    /// [`Bend::strain`] of a response, of which [`Arcs::find`] has found what is left.
    fn strain(&mut self, model: &Model, linear: &Linear, response: &Response) -> f64 {
        let (held, mechanisms, masses) = (linear.joints.held(), linear.joints.mechanisms(), linear.masses);
        self.energy.clear();
        self.energy.resize(held.len(), [0.0; 2]);
        let falling = (model.gravity * model.step).length_squared();
        for (b, whole) in held.iter().zip(mechanisms) {
            let falls = 0.5 * falling / masses.inv_mass[*b as usize];
            let kinetic = 0.5 * masses.energy::<false>(*b as usize, &response.twist[*b as usize]) + falls;
            self.energy[*whole as usize][1] += kinetic;
        }
        for (row, [.., work]) in linear.joints.rows.iter().zip(&self.found).filter(|(_, [_, left, ..])| *left > 1.0) {
            if let Some(k) = row.bodies.iter().find_map(|b| held.binary_search(b).ok()) {
                self.energy[mechanisms[k] as usize][0] += work;
            }
        }
        let strain = |[work, kinetic]: &[f64; 2]| if *work > 0.0 { work / kinetic } else { 0.0 };
        self.energy.iter().map(strain).fold(0.0, f64::max)
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

/// Whether a joint is a link of constant length, as a rope is while it is taut.
fn has_length(joint: &Joint, limits: &[Limit]) -> bool {
    let is_taut = joint.kind.coordinate() == Some(Coordinate::Length) && limits.iter().any(|limit| limit.is_held);
    joint.has_length() || is_taut
}

/// The greatest turn of a body on joints, or of a link of constant length, and the greatest change of such a rate, times the step; rad.
fn turning((model, state): (&Model, &State), linear: &Linear, response: &Response) -> [f64; 2] {
    let h = model.step;
    let of_rates = |[most, change]: [f64; 2], [before, after]: [DVec3; 2]| {
        [(after.length() * h).max(most), ((after - before).length() * h).max(change)]
    };
    let of_body = |b: &u32| [state.twist(*b as usize).w, response.twist[*b as usize].w];
    let bodies = linear.joints.held().iter().map(of_body).fold([0.0; 2], of_rates);
    let links = model.joints.iter().enumerate().filter(|(i, joint)| {
        let rows = linear.start[*i]..linear.start[*i + 1];
        has_length(joint, linear.joints.limits.of_joint(*i as u32)) && !rows.is_empty()
    });
    let of_link = |(_, joint): (usize, &Joint)| {
        let f = state.joint_frames(joint);
        let (along, arms) = (f.offset(), f.arms());
        let rate = |twists: [Twist; 2]| {
            let [a, b] = [0, 1].map(|k| twists[k].v + twists[k].w.cross(arms[k]));
            along.cross(b - a) / along.length_squared().max(f64::MIN_POSITIVE)
        };
        let now = joint.bodies.map(|b| state.twist(b as usize));
        let moved = |b: u32| if state.moves(b as usize) { response.twist[b as usize] } else { Twist::default() };
        [rate(now), rate(joint.bodies.map(moved))]
    };
    links.map(of_link).fold(bodies, of_rates)
}

/// The speed of a body by turning, at its radius of gyration, m/s.
fn spin_speed(model: &Model, b: u32, twist: Twist) -> f64 {
    gyration(model.inv_mass[b as usize], model.inv_inertia[b as usize].max_element()) * twist.w.length()
}

fn end_pose(model: &Model, state: &State, b: usize, response: &Response) -> Pose {
    if !state.moves(b) {
        return state.pose(b);
    }
    moved_pose(&state.pose(b), &response.twist[b], model.inv_inertia[b], model.step, None).0
}
