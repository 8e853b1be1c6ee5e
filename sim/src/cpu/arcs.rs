//! Bodies move on arcs, not straight on. What Ψ of a joint's row changes by in a step beyond h dΨ/dt, over h, is part of the row's bias: of links
//! that turn by ω h, ω² h/2 times their length, m/s. Without it that is their gap after the step, and the next one takes it back.
//!
//! Before the solve bodies are taken to go on as they move ([`predict`]). Where neither contacts nor limits act, the joints are then solved for the
//! arcs of the very motion that they give: Ψ is zero at the step's end, and energy stays. Where they act, which an impact would make wrong, what
//! the arcs are otherwise moves the bodies alone, not their velocities ([`follow`]).
//! Source: Ryckaert, Ciccotti and Berendsen, *Numerical integration of the cartesian equations of motion of a system with constraints* (1977).

use super::geometric_stiffness::Stiffness;
use super::integrate::moved_pose;
use super::masses::Masses;
use super::solve::joints::Joints;
use super::solve::response::Response;
use crate::joint::{Coordinate, Frames, Joint, Motor, Row};
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;

/// Angle by which a body of a joint turns in a step, rad, up to which its rows are straight.
const LEAST_TURN: f64 = 1e-5;

/// The mass of the heaviest body on a joint over that of a light one.
const LIGHT: f64 = 300.0;

/// Change of an arc, over the greatest arc, up to which it is the same.
const SAME: f64 = 1e-3;

/// What the greatest arc moves a body by in a step, m or rad, below which it counts as this.
const SHORT: f64 = 1e-6;

/// The energy of links over that with the arcs as predicted from which on these are not followed: links that pass a straight line would be thrown.
const GROWN: f64 = 1.02;

/// The change of arcs over that of the solve before from which on they are not followed either.
const SLOWER: f64 = 0.5;

/// The most solves for arcs in a step.
const MOST: usize = 4;

/// The arcs of the joints, as bodies move now, into the bias of their rows; `start` has the first row of each joint. Those of links too light for
/// the step, whose stiffness acts at its end, stay straight.
pub fn predict(model: &Model, state: &State, start: &[u32], stiffness: &Stiffness, joints: &mut Joints) {
    let Joints { rows, bias, arc, is_stiff, .. } = joints;
    arc.clear();
    arc.resize(rows.len(), 0.0);
    let inv_mass = |body: &u32| Some(model.inv_mass[*body as usize]).filter(|_| state.moves(*body as usize));
    let heaviest =
        model.joints.iter().flat_map(|joint| &joint.bodies).filter_map(inv_mass).fold(f64::INFINITY, f64::min);
    let is_light = |joint: &Joint| joint.bodies.iter().filter_map(inv_mass).any(|own| own > LIGHT * heaviest);
    is_stiff.clear();
    is_stiff.extend(model.joints.iter().enumerate().map(|(i, joint)| is_light(joint) && stiffness.acts_on((i, joint))));
    let bends = |i: usize| start[i] < start[i + 1] && !is_stiff[i];
    let mut arcs = Arcs { model, state, after: vec![] };
    for (i, joint) in model.joints.iter().enumerate().filter(|(i, _)| bends(*i)) {
        let motion = joint.bodies.map(|b| state.twist(b as usize));
        if turns(joint, motion, model.step) {
            let of_joint = start[i] as usize..start[i + 1] as usize;
            for (k, now) in of_joint.clone().zip(arcs.of(i, &rows[of_joint], motion)) {
                arc[k] = now;
                bias[k] += now;
            }
        }
    }
}

/// Solve the joints for the arcs of the motion of a response, where none of those bodies that are coupled is `touched` by a contact or a limit.
/// Returns rows of the others, and how much their arcs are greater than in their bias, m/s or rad/s, by which the bodies are to be moved less
/// ([`Joints::correct`]). `start` has the first row of each joint.
pub fn follow(
    (model, state, masses): (&Model, &State, &Masses),
    (joints, start): (&mut Joints, &[u32]),
    touched: impl Iterator<Item = u32>,
    response: &mut Response,
) -> Vec<(usize, f64)> {
    let ends = |i: usize| model.joints[i].bodies.map(|b| response.twist[b as usize]);
    let bends = |i: &usize| start[*i] < start[i + 1] && turns(&model.joints[*i], ends(*i), model.step);
    let bent: Vec<usize> = (0..model.joints.len()).filter(bends).collect();
    if bent.is_empty() {
        return vec![];
    }
    let mut is_touched = vec![false; model.n_bodies()];
    let moving = touched.filter(|body| masses.inv_mass[*body as usize] > 0.0);
    moving.for_each(|body| is_touched[joints.island(body) as usize] = true);
    let is_free = |i: &usize| !model.joints[*i].bodies.iter().any(|b| is_touched[joints.island(*b) as usize]);
    let (free, mut held): (Vec<usize>, Vec<usize>) = bent.into_iter().partition(is_free);
    let mut arcs = Arcs { model, state, after: vec![] };
    let mut changes = vec![];
    let energy = |response: &Response| -> f64 {
        let bodies = free.iter().flat_map(|i| model.joints[*i].bodies).map(|b| b as usize);
        bodies.map(|b| masses.energy::<false>(b, &response.twist[b])).sum()
    };
    let (before, mut made) = (energy(response), vec![]);
    let (mut last, mut is_wild) = (f64::INFINITY, false);
    for _ in 0..MOST {
        let change = arcs.change(&free, (joints, start), response, &mut changes);
        is_wild |= change > SLOWER * last;
        if change == 0.0 || is_wild {
            break;
        }
        last = change;
        joints.bend(&changes, 1.0);
        joints.solve(masses, response);
        made.append(&mut changes);
    }
    if is_wild || energy(response) > GROWN * before {
        joints.bend(&made, -1.0);
        joints.solve(masses, response);
        held.extend(&free);
    }
    held.retain(|i| !joints.is_stiff[*i]);
    if arcs.change(&held, (joints, start), response, &mut changes) == 0.0 {
        changes.clear();
    }
    changes
}

/// Whether a joint's rows bend in a step: its bodies turn, or it is a length, which swings round.
fn turns(joint: &Joint, motion: [Twist; 2], h: f64) -> bool {
    let least = LEAST_TURN / h;
    joint.kind.coordinate() == Some(Coordinate::Length)
        || motion.iter().any(|motion| motion.w.length_squared() > least * least)
}

/// The arcs of joints' rows.
struct Arcs<'a> {
    model: &'a Model,
    state: &'a State,
    /// Rows of a joint at the step's end.
    after: Vec<Row>,
}

impl Arcs<'_> {
    /// List the rows of some joints, and how their arcs change with the motion of a response, m/s or rad/s. Returns the greatest change, or 0
    /// where they are the same.
    fn change(
        &mut self,
        of: &[usize],
        (joints, start): (&Joints, &[u32]),
        response: &Response,
        changes: &mut Vec<(usize, f64)>,
    ) -> f64 {
        let (mut greatest, mut change) = (SHORT / self.model.step, 0.0f64);
        changes.clear();
        for i in of {
            let rows = start[*i] as usize..start[i + 1] as usize;
            let motion = self.model.joints[*i].bodies.map(|b| response.twist[b as usize]);
            for (k, now) in rows.clone().zip(self.of(*i, &joints.rows[rows], motion)) {
                changes.push((k, now - joints.arc[k]));
                greatest = greatest.max(now.abs());
                change = change.max((now - joints.arc[k]).abs());
            }
        }
        if change > SAME * greatest { change } else { 0.0 }
    }

    /// The arcs of joint `i`, whose rows are `rows`, of the motion of its bodies, m/s or rad/s.
    fn of(&mut self, i: usize, rows: &[Row], motion: [Twist; 2]) -> impl Iterator<Item = f64> {
        let Arcs { model, state, after } = self;
        let (joint, h) = (&model.joints[i], model.step);
        let poses = [0, 1].map(|k| {
            let b = joint.bodies[k] as usize;
            moved_pose(&state.pose(b), &motion[k], model.inv_inertia[b], h, None).0
        });
        after.clear();
        let frames = Frames::of(poses, &joint.frame_a, &joint.frame_b);
        joint.rows(&frames, &state.joints[i], state.time + h, after);
        // The row of a prescribed rate has no Ψ.
        let n = rows.len() - usize::from(matches!(joint.motor, Some(Motor::Speed(_))));
        let arc = move |(row, after): (&Row, &Row)| (after.psi - row.psi) / h - row.speed(motion[0], motion[1]);
        rows[..n].iter().zip(&*after).map(arc)
    }
}
