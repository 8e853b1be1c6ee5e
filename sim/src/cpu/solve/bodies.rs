//! N = Dᵀ M̃⁻¹ D, matrix-free: each block gives its impulse to its two bodies, tile by tile ([`crate::contacts::Tiles`]) and in a
//! fixed order, the joints answer, and the relative velocities are read block by block.
//!
//! Blocks: the contacts; then, where a material has rolling or spinning friction, a block of angular impulse for each contact;
//! then the limits of joints, one number each.

use super::cells::Cells;
use super::cone::project_cone;
use super::joints::Joints;
use super::response::Response;
use super::schedule;
use crate::contacts::Contacts;
use crate::cpu::masses::Masses;
use crate::joint::Row;
use crate::model::{ContactLaw, Model};
use crate::plan::StepPlan;
use crate::rows::sweep;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;
use std::ops::Range;

/// The bodies with gravity alone.
#[derive(Clone, Copy)]
pub struct Falling<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its state.
    pub state: &'a State,
}

impl Falling<'_> {
    /// The velocity of a body at the end of the step, world.
    #[inline]
    pub fn twist(&self, b: usize) -> Twist {
        let Falling { model, state } = self;
        if !state.moves(b) {
            return Twist::default();
        }
        Twist { v: state.velocity[b] + model.gravity * model.step, w: state.orientation[b] * state.angular_velocity[b] }
    }
}

/// Velocities without contacts and joints.
#[derive(Clone, Copy)]
pub enum Free<'a> {
    /// A column (n_bodies).
    Column(&'a [Twist]),
    /// Those of falling bodies, evaluated where they are asked for.
    Falling(Falling<'a>),
}

/// The normal part of b.
pub enum Offset<'a> {
    /// A column: Φ/h, what restitution asks, and what exact friction feeds (n_contacts + n_limits).
    Column(&'a mut [f64]),
    /// Φ/h of each contact ([`Recovery`]), evaluated where it is asked for; there are no limits.
    OfGap,
}

impl Offset<'_> {
    /// Some rows of the column.
    #[inline]
    pub fn column(&self, rows: Range<usize>) -> Option<&[f64]> {
        match self {
            Offset::Column(column) => Some(&column[rows]),
            Offset::OfGap => None,
        }
    }
}

/// How gaps close and overlaps are pushed apart.
#[derive(Clone, Copy)]
pub struct Recovery {
    /// h, s.
    pub step: f64,
    /// The greatest speed, m/s.
    pub speed: f64,
}

impl Recovery {
    /// Of a model.
    pub fn of(model: &Model) -> Recovery {
        Recovery { step: model.step, speed: model.solver.recovery_speed }
    }

    /// Φ/h, or as fast as an overlap may be pushed apart, m/s.
    #[inline]
    pub fn rate(&self, gap: f64) -> f64 {
        let rate = gap / self.step;
        if rate <= -self.speed { -self.speed } else { rate }
    }
}

/// The operator of a step.
pub struct BodyOperator<'a> {
    /// What the step needs.
    pub plan: &'a StepPlan,
    /// The contacts.
    pub contacts: &'a Contacts,
    /// The laws that their `law` points to.
    pub laws: &'a [ContactLaw],
    /// Masses in the world frame.
    pub masses: &'a Masses,
    /// Velocities without contacts and joints.
    pub free: Free<'a>,
    /// The joints.
    pub joints: &'a mut Joints,
    /// Limits of joints that may be met: dΨ/dt ≥ 0 once Ψ is 0.
    pub limits: &'a [Row],
    /// The normal part of b.
    pub offset: Offset<'a>,
    /// How overlaps are pushed apart.
    pub recovery: Recovery,
    /// The offset without what exact friction feeds (n_contacts + n_limits; none for the relaxed law).
    pub offset_unfed: &'a [f64],
    /// η (n_blocks; none for sweeps over spheres, which have no use for it).
    pub eta: &'a [f64],
    /// δ, m: cohesion reaches this far.
    pub envelope: f64,
}

/// What a block is.
pub enum Block {
    /// A contact.
    Contact(usize),
    /// The rolling and spinning friction of a contact.
    Roll(usize),
    /// The limit of a joint.
    Limit(usize),
}

impl BodyOperator<'_> {
    /// What a block is.
    #[inline]
    pub fn block(&self, i: usize) -> Block {
        let n = self.contacts.len();
        if i < n {
            Block::Contact(i)
        } else if self.plan.rolls && i < 2 * n {
            Block::Roll(i - n)
        } else {
            Block::Limit(i - if self.plan.rolls { 2 * n } else { n })
        }
    }

    /// The bodies of a block.
    pub fn bodies(&self, block: usize) -> [u32; 2] {
        match self.block(block) {
            Block::Contact(i) | Block::Roll(i) => self.contacts.bodies[i],
            Block::Limit(i) => self.limits[i].bodies,
        }
    }

    /// The normal part of b of a contact.
    #[inline]
    pub fn offset(&self, contact: usize) -> f64 {
        match &self.offset {
            Offset::Column(offset) => offset[contact],
            Offset::OfGap => self.recovery.rate(self.contacts.gap[contact]),
        }
    }

    /// The law of a contact.
    #[inline]
    pub fn law(&self, contact: usize) -> &ContactLaw {
        &self.laws[self.contacts.law[contact] as usize]
    }

    /// Relative velocity at a block, from motions.
    #[inline]
    pub fn relative(&self, i: usize, of: impl Fn(usize) -> Twist) -> DVec3 {
        match self.block(i) {
            Block::Contact(i) => {
                let [a, b] = self.contacts.bodies[i];
                let (a, b) = (of(a as usize), of(b as usize));
                let [arm_a, arm_b] = self.contacts.arms(i);
                let v = b.v + b.w.cross(arm_b) - a.v - a.w.cross(arm_a);
                v + self.contacts.normal[i] * self.offset(i)
            }
            Block::Roll(i) => {
                let [a, b] = self.contacts.bodies[i];
                of(b as usize).w - of(a as usize).w
            }
            Block::Limit(i) => {
                let row = &self.limits[i];
                let [a, b] = row.bodies.map(|b| of(b as usize));
                DVec3::new(row.speed(a, b) + self.offset(self.contacts.len() + i), 0.0, 0.0)
            }
        }
    }

    /// Project a block; `gamma` reads a contact's impulse, on which the width of its rolling cone depends.
    #[inline(always)]
    pub fn project_with(&self, i: usize, y: DVec3, gamma: impl Fn(usize) -> DVec3) -> DVec3 {
        match self.block(i) {
            Block::Contact(i) => {
                let (n, law) = (self.contacts.normal[i], self.law(i));
                if law.cohesion > 0.0 {
                    let tip = n * self.adhesion(i);
                    return project_cone(y + tip, n, law.friction) - tip;
                }
                project_cone(y, n, law.friction)
            }
            Block::Roll(i) => {
                let (n, law) = (self.contacts.normal[i], self.law(i));
                let normal = (gamma(i).dot(n) + self.adhesion(i)).max(0.0);
                let spin = y.dot(n);
                let roll = y - n * spin;
                let length = roll.length();
                let most = law.rolling * normal;
                let roll = if length > most { roll * (most / length) } else { roll };
                n * spin.clamp(-law.spinning * normal, law.spinning * normal) + roll
            }
            Block::Limit(_) => DVec3::new(y.x.max(0.0), 0.0, 0.0),
        }
    }

    /// What adhesion adds to the normal multiplier: the cone's tip is so far below zero.
    #[inline]
    fn adhesion(&self, contact: usize) -> f64 {
        let cohesion = self.law(contact).cohesion;
        if cohesion > 0.0 && self.contacts.gap[contact] <= self.envelope { cohesion * self.recovery.step } else { 0.0 }
    }

    /// The velocity of a body without contacts and joints.
    #[inline(always)]
    pub fn free(&self, body: usize) -> Twist {
        match &self.free {
            Free::Column(free) => free[body],
            Free::Falling(falling) => falling.twist(body),
        }
    }

    /// What a block's impulse gives to its bodies: `give(body, linear, angular)`.
    #[inline(always)]
    pub fn split(&self, i: usize, d: DVec3, give: impl Fn(u32, DVec3, DVec3)) {
        match self.block(i) {
            Block::Contact(i) => {
                let [a, b] = self.contacts.bodies[i];
                let [arm_a, arm_b] = self.contacts.arms(i);
                give(a, -d, -arm_a.cross(d));
                give(b, d, arm_b.cross(d));
            }
            Block::Roll(i) => {
                let [a, b] = self.contacts.bodies[i];
                give(a, DVec3::ZERO, -d);
                give(b, DVec3::ZERO, d);
            }
            Block::Limit(i) => {
                let row = &self.limits[i];
                give(row.bodies[0], row.linear * -d.x, row.angular_a * -d.x);
                give(row.bodies[1], row.linear * d.x, row.angular_b * d.x);
            }
        }
    }

    /// Add an impulse to what a body is given; one that is held in place takes none.
    ///
    /// # Safety
    /// No other thread touches the body's entry, if it moves.
    #[inline(always)]
    pub unsafe fn give(&self, sums: &Cells<Twist>, body: u32, impulse: &Twist) {
        let b = body as usize;
        if self.masses.inv_mass[b] > 0.0 {
            // SAFETY: the caller's promise.
            unsafe { sums.set(b, sums.get(b).plus(impulse)) };
        }
    }

    /// Add a block's impulse to what its bodies are given.
    ///
    /// # Safety
    /// No other thread touches the entries of the block's moving bodies.
    #[inline(always)]
    pub unsafe fn push(&self, i: usize, d: DVec3, sums: &Cells<Twist>) {
        // SAFETY: the caller's promise.
        self.split(i, d, |body, linear, angular| unsafe { self.give(sums, body, &Twist { v: linear, w: angular }) });
    }

    /// Nothing given to any body yet.
    pub fn nothing(&self, sums: &mut Vec<Twist>) {
        sums.clear();
        sums.resize(self.masses.inv_mass.len(), Twist::default());
    }

    /// Add the impulses of the blocks from `first` on.
    pub fn spread(&self, first: usize, gamma: &[DVec3], sums: &Cells<Twist>) {
        let limits = gamma.len() - self.limits.len()..gamma.len();
        // The contacts, then their rolling blocks.
        for first in (first..limits.start).step_by(self.contacts.len().max(1)) {
            // SAFETY: contacts that are visited at once share no moving body.
            schedule::each(self.contacts, |contact| unsafe {
                self.push(first + contact, gamma[first + contact], sums)
            });
        }
        // SAFETY: no other thread is at work.
        limits.for_each(|i| unsafe { self.push(i, gamma[i], sums) });
    }

    /// Make velocities of what bodies have been given, and let the joints answer.
    pub fn finish(&mut self, out: &mut Response) {
        let this = &*self;
        let [] = sweep(&mut out.twist, |first, rows| {
            // One that is held in place has been given nothing.
            let moved = |b: usize, sum: &Twist| this.free(b).plus(&this.masses.change::<false>(b, sum));
            rows.iter_mut().enumerate().for_each(|(k, t)| *t = moved(first + k, t));
            []
        });
        self.joints.begin(out);
        self.joints.answer(self.masses, out);
    }
}
