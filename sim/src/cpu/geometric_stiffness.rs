//! Geometric stiffness of joints and springs that carry loads too heavy for the step.
//!
//! The force F of a joint on a body at the arm r turns with nothing while the arm turns with the body: in the frame of the body its torque
//! changes by −K δθ with K = (F·r̂) (|r| 1 − r r̂ᵀ): none about the arm itself. Light links under tension swing fast, and where h²K is above
//! their inertia the explicit rows of a step shake them apart. There K acts at the step's end, as a stiff spring does: it is added to the
//! inertia, h²K for the links' rotation, and so S stays block-sparse. What the step
//! resolves as it can turn, about the point that a joint holds in place with the inertia about that, or with its inertia across its arms, is left as it is, but for light links under heavy
//! loads, which the rise of their inertia calms; a link of constant length resists transverse motion with F over its
//! length, by two rows. Inertia that is more than twice that of the step before takes over the momentum that is there: links that shake while
//! they turn taut would gain energy from nothing, if they kept their velocity.
//! Forces are those of the last step. Where joints of such bodies carry far more in this one, as when a chain becomes taut, the stiffness
//! follows: the joints are solved for their forces before the contacts are ([`Stiffness::follow`]).
//! Source: Andrews, Teichmann and Kry, *Geometric stiffness for real-time constrained multibody dynamics* (2017), with the threshold of
//! [`super::joint_write`] for springs.

use super::masses::Masses;
use super::solve::joints::Joints;
use crate::geometry::principal;
use crate::joint::{Coordinate, Frames, Joint, JointKind, Row, Spring, SpringKind, SpringState};
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Greatest h²K over the inertia: explicit motion is stable below 4.
const BOUND: f64 = 2.0;

/// Greatest mass over the least of bodies on joints from which on these are light links under heavy loads.
const LIGHT: f64 = 300.0;

/// Whether the bodies on the joints that act, with frames, are light links under heavy loads.
pub fn has_light_links(model: &Model, state: &State, frames: &[Option<Frames>]) -> bool {
    let acting = model.joints.iter().zip(frames).filter(|(_, f)| f.is_some()).flat_map(|(joint, _)| joint.bodies);
    let inverse = acting.filter(|b| state.moves(*b as usize)).map(|b| model.inv_mass[b as usize]);
    let [least, most] = inverse.fold([f64::INFINITY, 0.0f64], |[a, b], x| [a.min(x), b.max(x)]);
    most > LIGHT * least
}

/// The forces on A, N, of a spring with the frames `f`, in the last step and in that before it; those of one between angles pull at no arm.
pub fn spring_forces(spring: &Spring, f: &Frames, known: &SpringState) -> [DVec3; 2] {
    let along = f.offset().normalize_or_zero();
    let size = if spring.kind == SpringKind::Angle { [0.0; 2] } else { [known.force, known.force_before] };
    size.map(|size| along * size)
}

/// The geometric stiffness of the joints and springs of a step, and what of it acts at the end of the step.
#[derive(Default)]
pub struct Stiffness {
    /// Whether forces and arms are so great that the step may not resolve how stiff the rotation of a body is (n_bodies).
    is_near: Vec<bool>,
    /// The forces that turn such bodies.
    of_body: BTreeMap<u32, Pulled>,
    /// Transverse rows of links, with the stiffness, N/m, in place of the softness, and the joint or spring and the direction of each.
    transverse: Vec<(Row, [usize; 2])>,
    acting: Acting,
    /// Whether links are by far lighter than what they carry.
    pub is_light: bool,
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
    /// For a step of forces, N, of joints and springs with these frames on A, and against it on B.
    pub fn new<'a>(model: &Model, pulls: impl Iterator<Item = ([u32; 2], &'a Frames, DVec3)>) -> Stiffness {
        /// The norm of what [`Turning::add`] adds by a unit force along an arm of 1 m, a little more than √2.
        const ACROSS: f64 = 1.4143;
        let mut pulls = pulls.peekable();
        if pulls.peek().is_none() {
            return Stiffness::default();
        }
        let mut norm = vec![0.0; model.n_bodies()];
        for (bodies, f, force) in pulls {
            bodies.into_iter().zip(f.arms()).for_each(|(b, arm)| norm[b as usize] += ACROSS * force.dot(arm).abs());
        }
        let scale = model.step * model.step / BOUND;
        let is_near =
            norm.iter().zip(&model.inv_inertia).map(|(norm, inverse)| scale * norm * inverse.max_element() >= 1.0);
        Stiffness { is_near: is_near.collect(), ..Stiffness::default() }
    }

    /// Add the stiffness of joint `i` with the frames `f`, which carries a force now and carried another before.
    /// `moves` tells which bodies move.
    pub fn add(
        &mut self,
        (i, joint): (usize, &Joint),
        f: &Frames,
        [now, before]: [DVec3; 2],
        moves: impl Fn(u32) -> bool,
    ) {
        if now == DVec3::ZERO {
            return;
        }
        self.pivot(joint, f, moves);
        // The force has turned with the bodies since: its magnitude is compared, and whether it has reversed.
        let share = if now.dot(before) < 0.0 { 0.0 } else { before.length() / now.length() };
        self.turn(joint.bodies, f, [now, now * share]);
        if joint.kind.coordinate() == Some(Coordinate::Length) {
            self.swing(i, &joint.free_row(f, Coordinate::Length), f, now);
        }
    }

    /// Add the stiffness of a spring between two points with the frames `f`; `i` is its id, beyond those of the joints.
    pub fn add_spring(&mut self, (i, spring): (usize, &Spring), f: &Frames, known: &SpringState) {
        let forces = spring_forces(spring, f, known);
        if forces[0] == DVec3::ZERO {
            return;
        }
        self.turn(spring.bodies, f, forces);
        if spring.kind == SpringKind::Line {
            spring.rows(f, known).for_each(|along| self.swing(i, &along, f, forces[0]));
        }
    }

    /// Stiffness of the rotation of two bodies at whose arms forces act: those of the last step and of the step before it.
    fn turn(&mut self, bodies: [u32; 2], f: &Frames, forces_on_a: [DVec3; 2]) {
        for ((body, sign), arm) in bodies.into_iter().zip([1.0, -1.0]).zip(f.arms()) {
            if self.is_near[body as usize] {
                let pull = (arm, forces_on_a.map(|force| force * sign));
                self.of_body.entry(body).or_default().pulls.push(pull);
            }
        }
    }

    /// Have a joint that holds a point of a body in place be what the body turns about.
    fn pivot(&mut self, joint: &Joint, f: &Frames, moves: impl Fn(u32) -> bool) {
        use JointKind::{Fixed, Revolute, Spherical, Universal};
        let [a, b] = joint.bodies;
        if matches!(joint.kind, Spherical | Revolute | Universal | Fixed) && moves(a) != moves(b) {
            let k = if moves(a) { 0 } else { 1 };
            if !self.is_near[joint.bodies[k] as usize] {
                return;
            }
            self.of_body.entry(joint.bodies[k]).or_default().pivot = Some(f.arms()[k]);
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
        for (body, pulled) in &self.of_body {
            let Some(least) = least_moment(model, state, *body) else { continue };
            let own = target.masses.inertia(*body as usize);
            let Some(added) = pulled.asked(self.is_light, model, h, (*body, own, least)) else { continue };
            let own = DMat3::IDENTITY * least;
            let [_, before] = pulled.turning(DVec3::ZERO);
            let before = before.added(h, own).unwrap_or(DMat3::ZERO);
            let rise = positive(added - 2.0 * before - own);
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
        self.acts()
    }

    /// Whether something is too stiff for the step.
    pub fn acts(&self) -> bool {
        !(self.acting.inertia.is_empty() && self.acting.mass.is_empty())
    }

    /// Let more act where the forces `found`, by joints that have been solved with what acts, ask for more than twice the inertia. Returns
    /// whether there is such.
    pub fn follow(&mut self, found: &Stiffness, model: &Model, state: &State, h: f64, mut target: Target) -> bool {
        let mut has_more = false;
        for (body, pulled) in &found.of_body {
            let Some(least) = least_moment(model, state, *body) else { continue };
            let acting = self.acting.inertia.get(body).copied().unwrap_or(DMat3::ZERO);
            let own = target.masses.inertia(*body as usize) - acting;
            let Some(asked) = pulled.asked(self.is_light, model, h, (*body, own, least)) else { continue };
            if principal(asked - 2.0 * acting).0.max_element() > 2.0 * least {
                let more = positive(asked - acting);
                target.stiffen(*body, more, more);
                self.acting.inertia.insert(*body, acting + more);
                has_more = true;
            }
        }
        for (row, i) in &found.transverse {
            let acting = self.acting.mass.get(i).copied().unwrap_or(0.0);
            let own = 1.0 / target.masses.response(row);
            let asked = h * h * row.softness / BOUND - own;
            if asked > 2.0 * (acting + own) {
                target.resist(row, asked - acting);
                self.acting.mass.insert(*i, asked);
                has_more = true;
            }
        }
        has_more
    }
}

/// What pulls at a body.
#[derive(Default)]
struct Pulled {
    /// Arms of the joints and springs, m, and their forces in the last step and in that before it, N; world.
    pulls: Vec<(DVec3, [DVec3; 2])>,
    /// Arm of a point of it that is held in place, m.
    pivot: Option<DVec3>,
}

impl Pulled {
    /// The stiffness about a point at an arm from the centre of mass, by the forces of the last step and of that before it.
    fn turning(&self, about: DVec3) -> [Turning; 2] {
        let mut turning = [Turning::NONE; 2];
        for (arm, forces) in &self.pulls {
            for (turning, force) in turning.iter_mut().zip(forces) {
                turning.add(*arm - about, *force);
            }
        }
        turning
    }

    /// What a body with the inertia `own` and the least moment `least`, kg m², must have more of it for the step `h`, s, by the forces of the last step;
    /// none if the step resolves these, but for light links as the body can turn.
    fn asked(&self, is_light: bool, model: &Model, h: f64, (body, own, least): (u32, DMat3, f64)) -> Option<DMat3> {
        let [now, _] = self.turning(DVec3::ZERO);
        if !now.is_stiff(h, least) || !is_light && self.is_resolved(model, h, own, body) {
            return None;
        }
        now.added(h, DMat3::IDENTITY * least)
    }

    /// Whether the step `h`, s, resolves the stiffness as the body can turn: about its pivot, or its centre of mass with the inertia `own`, kg m².
    fn is_resolved(&self, model: &Model, h: f64, own: DMat3, body: u32) -> bool {
        let [now, _] = self.turning(self.pivot.unwrap_or(DVec3::ZERO));
        now.added(h, own + self.about_pivot(model, body)).is_none()
    }

    /// What the inertia about the pivot has more than that about the centre of mass, kg m².
    fn about_pivot(&self, model: &Model, body: u32) -> DMat3 {
        let Some(r) = self.pivot else { return DMat3::ZERO };
        let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        (DMat3::IDENTITY * r.length_squared() - outer) * (1.0 / model.inv_mass[body as usize])
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
        self.joints.push(Row { softness: 1.0 / added, ..*row }, 0.0, -row.speed_in(self.free));
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

    /// Whether the step `h`, s, may not resolve the stiffness on a body whose least moment is `least`, kg m².
    fn is_stiff(&self, h: f64, least: f64) -> bool {
        // The greatest eigenvalue is at most the norm.
        let norm = self.0.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        h * h * norm >= BOUND * least
    }

    /// What an inertia `own`, kg m², world, must have more for the step `h`, s; none if the step resolves the stiffness.
    fn added(&self, h: f64, own: DMat3) -> Option<DMat3> {
        let added = positive(self.0 * (h * h / BOUND) - own);
        (added != DMat3::ZERO).then_some(added)
    }
}

/// The part of a symmetric tensor whose eigenvalues are positive.
fn positive(tensor: DMat3) -> DMat3 {
    let (values, axes) = principal(tensor);
    let axes = DMat3::from_quat(axes);
    axes * DMat3::from_diagonal(values.max(DVec3::ZERO)) * axes.transpose()
}
