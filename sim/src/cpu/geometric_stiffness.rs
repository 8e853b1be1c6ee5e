//! Geometric stiffness of joints and springs that carry loads too heavy for the step.
//!
//! The force F of a joint on a body at the arm r turns with nothing while the arm turns with the body: in the frame of the body its torque
//! changes by −K δθ with K = (F·r̂) (|r| 1 − r r̂ᵀ): none about the arm itself. Light links under tension swing fast, and where h²K is above
//! their inertia the explicit rows of a step shake them apart. There K acts at the step's end, as a stiff spring does: it is added to the
//! inertia, h²K for the links' rotation, and so S stays block-sparse; a link of constant length resists transverse motion with F over its
//! length, by two rows. Inertia that is more than twice that of the step before takes over the momentum that is there: links that shake while
//! they turn taut would gain energy from nothing, if they kept their velocity.
//! Forces are those of the last step. Where joints of such bodies carry far more in this one, as when a chain becomes taut, the stiffness
//! follows: the joints are solved for their forces before the contacts are ([`Stiffness::follow`]).
//! Source: Andrews, Teichmann and Kry, *Geometric stiffness for real-time constrained multibody dynamics* (2017), with the threshold of
//! [`super::joint_write`] for springs.

use super::masses::Masses;
use super::solve::joints::Joints;
use crate::geometry::principal;
use crate::joint::{Coordinate, Frames, Joint, Row, Spring, SpringKind, SpringState};
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Greatest h²K over the inertia: explicit motion is stable below 4.
const BOUND: f64 = 2.0;

/// The geometric stiffness of the joints and springs of a step, and what of it acts at the end of the step.
#[derive(Default)]
pub struct Stiffness {
    /// That of the rotation of bodies, by the forces of the last step and by those of the step before it.
    of_body: BTreeMap<u32, [Turning; 2]>,
    /// Transverse rows of links, with the stiffness, N/m, in place of the softness, and the joint or spring and the direction of each.
    transverse: Vec<(Row, [usize; 2])>,
    acting: Acting,
}

/// What is added for a step.
#[derive(Default)]
struct Acting {
    /// To the inertia of bodies, kg m², world.
    inertia: BTreeMap<u32, DMat3>,
    /// To the mass across links, kg, by joint, or n_joints + spring, and direction.
    mass: BTreeMap<[usize; 2], f64>,
}

/// The parts of a step that stiffness changes.
pub struct Target<'a> {
    /// Masses and inertia tensors.
    pub masses: &'a mut Masses,
    /// Velocities without joints (n_bodies).
    pub free: &'a mut [Twist],
    /// The rows.
    pub joints: &'a mut Joints,
}

impl Stiffness {
    /// Add the stiffness of joint `i` with the frames `f`, which carries a force now and carried another before.
    pub fn add(&mut self, (i, joint): (usize, &Joint), f: &Frames, [now, before]: [DVec3; 2]) {
        if now == DVec3::ZERO {
            return;
        }
        // The force has turned with the bodies since: its magnitude is compared, and whether it has reversed.
        let share = if now.dot(before) < 0.0 { 0.0 } else { before.length() / now.length() };
        self.turn(joint.bodies, f, [now, now * share]);
        if joint.kind.coordinate() == Some(Coordinate::Length) {
            self.swing(i, &joint.free_row(f, Coordinate::Length), f, now);
        }
    }

    /// Add the stiffness of a spring between two points with the frames `f`; `i` is its id, beyond those of the joints.
    pub fn add_spring(&mut self, (i, spring): (usize, &Spring), f: &Frames, known: &SpringState) {
        if known.force == 0.0 || spring.kind == SpringKind::Angle {
            return;
        }
        let along = f.offset().normalize_or_zero();
        let pull = along * known.force;
        self.turn(spring.bodies, f, [pull, along * known.force_before]);
        if spring.kind == SpringKind::Line {
            spring.rows(f, known).for_each(|along| self.swing(i, &along, f, pull));
        }
    }

    /// Stiffness of the rotation of two bodies at whose arms forces act: those of the last step and of the step before it.
    fn turn(&mut self, bodies: [u32; 2], f: &Frames, forces_on_a: [DVec3; 2]) {
        for ((body, sign), arm) in bodies.into_iter().zip([1.0, -1.0]).zip(f.arms()) {
            let of_body = self.of_body.entry(body).or_insert([Turning::NONE; 2]);
            for (turning, force_on_a) in of_body.iter_mut().zip(forces_on_a) {
                turning.add(arm, force_on_a * sign);
            }
        }
    }

    /// Stiffness of a link across it: its force over its length.
    fn swing(&mut self, i: usize, along: &Row, f: &Frames, force_on_a: DVec3) {
        let stiffness = along.linear.dot(force_on_a) / along.psi.max(f64::MIN_POSITIVE);
        let (u, w) = along.linear.any_orthonormal_pair();
        let [a, b] = f.arms();
        self.transverse.extend([u, w].into_iter().enumerate().map(|(k, e)| {
            let (angular_a, angular_b) = (a.cross(e), b.cross(e));
            let row =
                Row { bodies: along.bodies, linear: e, angular_a, angular_b, softness: stiffness, ..Row::default() };
            (row, [i, k])
        }));
    }

    /// Let what is too stiff for the step `h` act at its end: on the inertia of bodies and their velocities without joints, and as rows.
    /// Returns whether there is such.
    pub fn apply(&mut self, model: &Model, state: &State, h: f64, mut target: Target) -> bool {
        for (body, [now, before]) in &self.of_body {
            let Some(least) = least_moment(model, state, *body) else { continue };
            let Some(added) = now.added(h, least) else { continue };
            let before = before.added(h, least).unwrap_or(DMat3::ZERO);
            let rise = positive(added - 2.0 * before - DMat3::IDENTITY * least);
            target.stiffen(*body, added, rise);
            self.acting.inertia.insert(*body, added);
        }
        for (row, i) in &self.transverse {
            let added = h * h * row.softness / BOUND - 1.0 / target.masses.response(row);
            if added > 0.0 {
                target.resist(row, added);
                self.acting.mass.insert(*i, added);
            }
        }
        !(self.acting.inertia.is_empty() && self.acting.mass.is_empty())
    }

    /// Let more act where the forces `found`, by joints that have been solved with what acts, ask for more than twice the inertia. Returns
    /// whether there is such.
    pub fn follow(&mut self, found: &Stiffness, model: &Model, state: &State, h: f64, mut target: Target) -> bool {
        let mut has_more = false;
        for (body, [now, _]) in &found.of_body {
            let Some(least) = least_moment(model, state, *body) else { continue };
            let Some(asked) = now.added(h, least) else { continue };
            let acting = self.acting.inertia.entry(*body).or_insert(DMat3::ZERO);
            if principal(asked - 2.0 * *acting).0.max_element() > 2.0 * least {
                let more = positive(asked - *acting);
                target.stiffen(*body, more, more);
                *acting += more;
                has_more = true;
            }
        }
        for (row, i) in &found.transverse {
            let acting = self.acting.mass.entry(*i).or_default();
            let own = 1.0 / target.masses.response(row);
            let asked = h * h * row.softness / BOUND - own;
            if asked > 2.0 * (*acting + own) {
                target.resist(row, asked - *acting);
                *acting = asked;
                has_more = true;
            }
        }
        has_more
    }
}

impl Target<'_> {
    /// Add to the inertia of a body; of that `rise` takes over the momentum that is there.
    fn stiffen(&mut self, body: u32, added: DMat3, rise: DMat3) {
        let b = body as usize;
        self.masses.stiffen(b, added);
        self.free[b].w -= self.masses.apply_inv_inertia(b, rise * self.free[b].w);
    }

    /// Add to the mass across a link.
    fn resist(&mut self, row: &Row, added: f64) {
        self.joints.rows.push(Row { softness: 1.0 / added, ..*row });
        self.joints.bias.push(-row.speed_in(self.free));
    }
}

/// The least moment of inertia of a body, kg m²; none if it does not move.
fn least_moment(model: &Model, state: &State, body: u32) -> Option<f64> {
    let b = body as usize;
    state.moves(b).then(|| model.inv_inertia[b].max_element().recip())
}

/// Geometric stiffness of the rotation of a body, N m/rad, world.
#[derive(Clone, Copy)]
struct Turning(DMat3);

impl Turning {
    /// Of no force.
    const NONE: Turning = Turning(DMat3::ZERO);

    /// Add that of a force at an arm. In the frame of the body, where the torque about the arm is 0 however the body turns.
    fn add(&mut self, arm: DVec3, force: DVec3) {
        let along = arm.normalize_or_zero();
        let across = DMat3::IDENTITY - DMat3::from_cols(along * along.x, along * along.y, along * along.z);
        self.0 += across * force.dot(arm);
    }

    /// What the inertia of a body whose least moment is `least`, kg m², must have more for the step `h`, s; none if the step resolves the
    /// stiffness.
    fn added(&self, h: f64, least: f64) -> Option<DMat3> {
        // The greatest eigenvalue is at most the norm.
        let norm = self.0.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        if h * h * norm < BOUND * least {
            return None;
        }
        let added = positive(self.0 * (h * h / BOUND) - DMat3::IDENTITY * least);
        (added != DMat3::ZERO).then_some(added)
    }
}

/// The part of a symmetric tensor whose eigenvalues are positive.
fn positive(tensor: DMat3) -> DMat3 {
    let (values, axes) = principal(tensor);
    let axes = DMat3::from_quat(axes);
    axes * DMat3::from_diagonal(values.max(DVec3::ZERO)) * axes.transpose()
}
