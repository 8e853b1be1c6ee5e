//! The bodies that joints, springs and loads act on, for a back end that solves the contacts elsewhere: their state stays here, in double
//! precision, with the rows of their joints, factorised. [`Mechanism::begin`] is all that comes before the contacts; with the impulses of
//! the contacts, [`Mechanism::finish`] is all that comes after them.
//! in     position, orientation, velocity, angular_velocity  of these bodies
//! out    joint_row, joint_bias  [n_rows]     as of `joint_write`
//! out    free                   [n_members]  m/s, rad/s: velocities with joints and without contacts
//! inout  joints, springs        of the state
//! The joints hold on the arcs of the step ([`super::arcs`]): as those are without contacts, for these, and at its end with them.
//! Which limits of joints hold, and which motors give their maximum effort, [`Mechanism::settle`] finds by rounds ([`super::solve::pivoting`]).
//! The stages are those of the CPU back end: `force`, `joint_write`, the elimination of `solve::joints`, `integrate`.

use super::arcs::{Arcs, Linear};
use super::integrate::moved_pose;
use super::masses::Masses;
use super::solve::bodies::Falling;
use super::solve::joints::{Joints, Reduced, on_body};
use super::solve::response::Response;
use super::{force, joint_write};
use crate::joint::Row;
use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::state::State;
use crate::twist::Twist;
use glam::{DQuat, DVec3};

/// The bodies, with the columns of their stages.
#[derive(Default)]
pub struct Mechanism {
    /// Ids of the bodies, ascending: those that move.
    pub bodies: Vec<u32>,
    masses: Masses,
    /// Velocities without contacts and joints (n_bodies; of these bodies alone).
    free: Vec<Twist>,
    joint_start: Vec<u32>,
    /// The rows of the joints.
    pub joints: Joints,
    /// Their factorisation for single precision.
    pub reduced: Reduced,
    /// The greatest rate by which a limit or a motor is on the wrong side after the last round of the step, m/s or rad/s.
    unsettled: f64,
    /// Velocities with joints (n_bodies; of these bodies alone).
    response: Response,
    /// Displacements over the step (the same).
    moved: Response,
    arcs: Arcs,
}

/// What the contacts do to a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effect {
    /// Impulse, N s, and angular impulse, N m s.
    pub impulse: Twist,
    /// The same of the pushes that recover overlaps.
    pub push: Twist,
    /// Sum of pushes × relative velocities, J s, where that keeps the angular momentum.
    pub turn: DVec3,
}

impl Mechanism {
    /// For the bodies that move now.
    pub fn prepare(&mut self, model: &Model, state: &State) {
        let joints = model.joints.iter().flat_map(|joint| joint.bodies);
        let springs = model.springs.iter().flat_map(|spring| spring.bodies);
        let loads = model.loads.iter().map(|load| load.body);
        let all = joints.chain(springs).chain(loads).filter(|b| state.moves(*b as usize));
        self.bodies = all.collect();
        self.bodies.sort_unstable();
        self.bodies.dedup();
        self.masses.prepare(model, state);
        self.joints.invalidate();
        self.free = vec![Twist::default(); model.n_bodies()];
        self.response.twist = self.free.clone();
        self.moved.twist = self.free.clone();
    }

    /// Forces, rows of the joints and their factorisation, and the velocities without contacts, which `impacts` before these change (n_bodies,
    /// or none). Returns whether the structure of the factor is another.
    pub fn begin(&mut self, model: &Model, state: &State, impacts: &[Twist]) -> bool {
        let Mechanism { bodies, masses, free, joint_start: start, joints, .. } = self;
        masses.rotate_bodies(model, state, bodies.iter().map(|b| *b as usize));
        let falling = Falling { model, state };
        for b in bodies.iter().map(|b| *b as usize) {
            free[b] = falling.twist(b);
            if let Some(Twist { v, w }) = impacts.get(b) {
                free[b] = Twist { v: free[b].v + *v, w: free[b].w + *w };
            }
        }
        force::apply(model, state, masses, free);
        joint_write::run(model, state, masses, joint_write::Output { start, joints, free });
        joints.begin_rounds();
        self.unsettled = 0.0;
        self.hold(model, state)
    }

    /// Factorise the rows, with motors and limits as they are, and have the arcs of the step without contacts in them. Returns whether the structure of
    /// the factor is another.
    fn hold(&mut self, model: &Model, state: &State) -> bool {
        self.joints.prepare(&self.masses);
        self.joints.reduce(&self.masses, &mut self.reduced);
        let is_new = self.joints.take_is_new();
        self.respond(&[]);
        let Mechanism { masses, free, joint_start: start, joints, response, arcs, .. } = self;
        arcs.foresee((model, state), Linear { start, joints, masses }, free, response);
        is_new
    }

    /// Whether there are limits that may be met in the step, or motors with a maximum effort.
    pub fn has_bounds(&self) -> bool {
        self.joints.n_bounds() > 0
    }

    /// Let go of the limits that would pull with what the contacts do, and hold those that would be passed; the same of motors, which would give more
    /// than their maximum or go beyond their rate. Returns whether there are such, so that the contacts are to be solved again, and whether the
    /// structure of the factor is another.
    pub fn settle(&mut self, (model, state): (&Model, &State), effects: &[Effect]) -> Option<bool> {
        /// A rate that is rounding, over that of the mechanism.
        const ROUNDING: f64 = 1e-6;
        self.respond(effects);
        let fastest = self.bodies.iter().map(|b| self.twist(*b)).map(|t| t.v.length().max(t.w.length()));
        let fastest = fastest.fold(0.0, f64::max);
        let is_another;
        (is_another, self.unsettled) = self.joints.end_round(&self.masses, &mut self.response, ROUNDING * fastest);
        is_another.then(|| self.hold(model, state))
    }

    /// The velocities that impulses on the bodies give, with their joints.
    fn respond(&mut self, effects: &[Effect]) {
        let Mechanism { bodies, masses, free, joints, response, .. } = self;
        bodies.iter().for_each(|b| response.twist[*b as usize] = free[*b as usize]);
        for (b, effect) in bodies.iter().zip(effects) {
            masses.apply_impulse(&mut response.twist, *b, effect.impulse.v, effect.impulse.w);
        }
        joints.reset(response);
        joints.solve(masses, response);
    }

    /// Velocities of a body with joints, m/s, rad/s.
    pub fn twist(&self, body: u32) -> Twist {
        self.response.twist[body as usize]
    }

    /// Inverse principal moments, 1/(kg m²), and principal frame of the inertia that a body has in this step: with the geometric stiffness
    /// of its joints.
    pub fn inertia(&self, model: &Model, state: &State, body: u32) -> (DVec3, DQuat) {
        self.masses.principal(model, state, body as usize)
    }

    /// The Jacobian of a row on one of its bodies, and the velocities that a unit impulse along it gives the body; none of a body that does
    /// not move.
    pub fn side(&self, row: &Row, body: u32) -> Option<[Twist; 2]> {
        let jacobian = on_body(row, body);
        let moves = self.masses.inv_mass[body as usize] > 0.0;
        moves.then(|| [jacobian, self.masses.change::<false>(body as usize, &jacobian)])
    }

    /// The end of the step, with what the contacts do to each of the bodies; of the displacement by the pushes a share is made. Records the
    /// joints and springs, and moves the bodies.
    pub fn finish(
        &mut self,
        model: &Model,
        state: &mut State,
        (effects, share): (&[Effect], f64),
        outcome: &mut StepOutcome,
    ) {
        self.respond(effects);
        let Mechanism { masses, joint_start: start, joints, response, arcs, .. } = self;
        arcs.hold((model, &*state), Linear { start, joints, masses }, response);
        if share > 0.0 {
            self.displace(effects);
        }
        if share > 0.0 && model.gravity == DVec3::ZERO {
            self.keep_angular_momentum(effects, 0.5 * share * model.step);
        }
        outcome.solver.residual = outcome.solver.residual.max(self.unsettled);
        let rows = (&self.joint_start[..], &self.joints);
        joint_write::record(model, state, rows, &self.response, outcome);
        for b in self.bodies.iter().map(|b| *b as usize) {
            let (motion, inverse, h) = (&self.response.twist[b], model.inv_inertia[b], model.step);
            let moved = (share > 0.0).then(|| (&self.moved.twist[b], share * h));
            let (pose, spin) = moved_pose(&state.pose(b), motion, inverse, h, moved);
            (state.position[b], state.orientation[b]) = (pose.position, pose.orientation);
            (state.velocity[b], state.angular_velocity[b]) = (motion.v, spin);
        }
    }

    /// The displacement by the pushes, over the step.
    fn displace(&mut self, effects: &[Effect]) {
        let Mechanism { bodies, masses, joints, moved, .. } = self;
        bodies.iter().for_each(|b| moved.twist[*b as usize] = Twist::default());
        for (b, effect) in bodies.iter().zip(effects) {
            masses.apply_impulse(&mut moved.twist, *b, effect.push.v, effect.push.w);
        }
        joints.reset(moved);
        joints.solve_at_rest(masses, moved);
    }

    /// Turn the bodies so that the displacement leaves the angular momentum as it is: by the pushes of contacts, and by those of joints.
    fn keep_angular_momentum(&mut self, effects: &[Effect], half: f64) {
        let Mechanism { bodies, masses, joints, response, moved, .. } = self;
        for (b, effect) in bodies.iter().zip(effects) {
            masses.apply_impulse(&mut response.twist, *b, DVec3::ZERO, effect.turn * -half);
        }
        let move_both = |row: &Row| row.bodies.iter().all(|b| masses.inv_mass[*b as usize] > 0.0);
        for (row, impulse) in joints.rows.iter().zip(&moved.lambda).filter(|(row, _)| move_both(row)) {
            let [a, b] = row.bodies.map(|b| response.twist[b as usize].v);
            let turn = (row.linear * *impulse).cross(b - a) * -half;
            row.bodies.iter().for_each(|b| masses.apply_impulse(&mut response.twist, *b, DVec3::ZERO, turn));
        }
    }
}
