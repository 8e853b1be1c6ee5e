//! N = Dᵀ M̃⁻¹ D, matrix-free: the impulse of each block is applied to its two bodies, tile by tile ([`crate::contacts::Tiles`]) and
//! in a fixed order, the joints are solved, and the relative velocities are evaluated block by block.
//!
//! Blocks: the contacts; then, where a material has rolling or spinning friction, a block of angular impulse for each contact.

use super::cells::Cells;
use super::cone::project_cone;
use super::joints::Joints;
use super::response::Response;
use super::schedule;
use crate::contacts::Contacts;
use crate::cpu::masses::Masses;
use crate::model::{ContactLaw, Model};
use crate::plan::StepPlan;
use crate::rows::reduce_chunks;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;
use std::ops::Range;

/// The motion of the bodies under gravity alone.
#[derive(Clone, Copy)]
pub struct Falling<'a> {
    /// The model.
    pub model: &'a Model,
    /// The state.
    pub state: &'a State,
}

impl Falling<'_> {
    /// Velocities of a body at the step's end, world.
    #[inline]
    pub fn twist(&self, b: usize) -> Twist {
        let Falling { model, state } = self;
        if !state.moves(b) {
            return Twist::default();
        }
        let kept = self.kept(b);
        let (v, w) = (state.velocity[b] * kept, state.angular_velocity[b] * kept);
        Twist { v: v + model.gravity * model.step, w: state.orientation[b] * w }
    }

    /// The share of its velocity that a body that moves keeps: that of its speed, with that of its turning at the radius of gyration, in
    /// `rest_speed`.
    #[inline]
    fn kept(&self, b: usize) -> f64 {
        let Falling { model, state } = self;
        let least = model.solver.rest_speed;
        if least == 0.0 {
            return 1.0;
        }
        let (v, w, inverse) = (state.velocity[b], state.angular_velocity[b], model.inv_inertia[b]);
        let turning = |k: usize| if w[k] == 0.0 { 0.0 } else { w[k] * w[k] / inverse[k] };
        let speed2 = v.length_squared() + model.inv_mass[b] * (turning(0) + turning(1) + turning(2));
        (speed2.sqrt() / least).min(1.0)
    }
}

/// Velocities without contacts and joints, world.
#[derive(Clone, Copy)]
pub enum Free<'a> {
    /// A column (n_bodies).
    Column(&'a [Twist]),
    /// Velocities under gravity alone, evaluated where they are read.
    Falling(Falling<'a>),
}

/// The normal parts of b, m/s.
pub enum Offset<'a> {
    /// A column: Φ/h or the restitution velocity, and the slip feedback of exact friction (n_contacts).
    Column(&'a mut [f64]),
    /// Φ/h of each contact ([`Recovery`]), evaluated where it is read; there are no joints.
    OfGap,
}

impl Offset<'_> {
    /// Rows of the column, if it is one.
    #[inline]
    pub fn column(&self, rows: Range<usize>) -> Option<&[f64]> {
        match self {
            Offset::Column(column) => Some(&column[rows]),
            Offset::OfGap => None,
        }
    }
}

/// The rate of gaps: open gaps close within the step; overlaps are recovered at a bounded speed, apart from the velocities
/// ([`super::overlaps`]), and a share of those of faces and of bodies on joints by the contacts' impulses, which lift a machine on its
/// light links and a pile of stones.
#[derive(Clone, Copy)]
pub struct Recovery {
    /// Step size h, s.
    pub step: f64,
    /// Maximum speed of recovery, m/s.
    pub speed: f64,
    /// Gap at which bodies other than spheres come to rest, m.
    pub rest_gap: f64,
    /// Overlap that is left as it is, m: a tenth of what gravity moves a body in a step.
    pub least: f64,
}

impl Recovery {
    /// The recovery of a model.
    pub fn of(model: &Model) -> Recovery {
        let h = model.step;
        Recovery {
            step: h,
            speed: model.solver.recovery_speed,
            rest_gap: model.solver.rest_gap,
            least: 0.1 * model.gravity.length() * h * h,
        }
    }

    /// Φ/h of an open gap, m/s; 0 for an overlap.
    #[inline]
    pub fn rate(&self, gap: f64) -> f64 {
        if gap <= 0.0 { 0.0 } else { gap / self.step }
    }

    /// Φ/h of a contact of a body on joints or of a face; for an overlap a share of what is beyond that of rest, at least minus the
    /// maximum speed of recovery and ten times what gravity adds to a speed in a step, m/s.
    #[inline]
    pub fn lifting_rate(&self, gap: f64) -> f64 {
        const SHARE: f64 = 1.0 / 8.0;
        let of_rest = 10.0 * self.least;
        if gap > 0.0 {
            return (gap - self.rest_gap).max(0.0) / self.step;
        }
        ((SHARE * (gap + of_rest).min(0.0)).max(-10.0 * of_rest) / self.step).max(-self.speed)
    }

    /// Speed at which what is left of an overlap after the step, in which it changes at `speed`, is recovered for `steps` steps, m/s.
    #[inline]
    pub fn overlap_speed(&self, gap: f64, speed: f64, steps: f64) -> f64 {
        (-(gap + self.least) / self.step - speed).clamp(0.0, self.speed * steps)
    }
}

/// The operator of a step.
pub struct BodyOperator<'a> {
    /// The plan of the step.
    pub plan: &'a StepPlan,
    /// The contacts.
    pub contacts: &'a Contacts,
    /// The contact laws of the model.
    pub laws: &'a [ContactLaw],
    /// Masses and inertia tensors in the world frame.
    pub masses: &'a Masses,
    /// Velocities without contacts and joints.
    pub free: Free<'a>,
    /// The joints.
    pub joints: &'a mut Joints,
    /// The normal parts of b, m/s.
    pub offset: Offset<'a>,
    /// The rate of gaps.
    pub recovery: Recovery,
    /// The offset without slip feedback (n_contacts; empty for the relaxed law).
    pub offset_without_slip: &'a [f64],
    /// Slip over μ below which none is fed back: the speed of one step of free fall, m/s.
    pub least_slip: f64,
    /// The direction of gravity, unit; zero without.
    pub down: DVec3,
    /// The slip μ |v_t| of the contacts at the velocities of the step's start, m/s (n_contacts; empty for the relaxed law).
    pub last_slip: &'a [f64],
    /// η (n_blocks; empty for sweeps on packed contacts, which do not use it).
    pub eta: &'a [f64],
    /// Envelope δ, m: the range of cohesion.
    pub envelope: f64,
}

/// The kind of a block, with the index of its contact.
pub enum Block {
    /// A contact.
    Contact(usize),
    /// The rolling and spinning friction of a contact.
    Roll(usize),
}

impl BodyOperator<'_> {
    /// The kind of a block.
    #[inline]
    pub fn block(&self, i: usize) -> Block {
        let n = self.contacts.len();
        if i < n { Block::Contact(i) } else { Block::Roll(i - n) }
    }

    /// Ids of the bodies of a block.
    pub fn bodies(&self, block: usize) -> [u32; 2] {
        match self.block(block) {
            Block::Contact(i) | Block::Roll(i) => self.contacts.bodies[i],
        }
    }

    /// The normal part of b of a contact, m/s.
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

    /// Relative velocity of a block plus b, m/s (rad/s for rolling blocks); `of` has the velocities of the bodies.
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
        }
    }

    /// Project a block onto its cone; `gamma` reads a contact's multipliers, on which the width of its rolling cone depends.
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
                let max = law.rolling * normal;
                let roll = if length > max { roll * (max / length) } else { roll };
                n * spin.clamp(-law.spinning * normal, law.spinning * normal) + roll
            }
        }
    }

    /// Adhesion of a contact, N s: the depth of the cone's tip below zero.
    #[inline]
    pub fn adhesion(&self, contact: usize) -> f64 {
        let cohesion = self.law(contact).cohesion;
        if cohesion > 0.0 && self.contacts.gap[contact] <= self.envelope { cohesion * self.recovery.step } else { 0.0 }
    }

    /// Velocities of a body without contacts and joints, world.
    #[inline(always)]
    pub fn free(&self, body: usize) -> Twist {
        match &self.free {
            Free::Column(free) => free[body],
            Free::Falling(falling) => falling.twist(body),
        }
    }

    /// Split a block's impulse into those on its bodies: `apply(body, linear, angular)`.
    #[inline(always)]
    pub fn split(&self, i: usize, d: DVec3, apply: impl Fn(u32, DVec3, DVec3)) {
        match self.block(i) {
            Block::Contact(i) => {
                let [a, b] = self.contacts.bodies[i];
                let [arm_a, arm_b] = self.contacts.arms(i);
                apply(a, -d, -arm_a.cross(d));
                apply(b, d, arm_b.cross(d));
            }
            Block::Roll(i) => {
                let [a, b] = self.contacts.bodies[i];
                apply(a, DVec3::ZERO, -d);
                apply(b, DVec3::ZERO, d);
            }
        }
    }

    /// Add an impulse to the sum of a body, unless it is held in place.
    ///
    /// # Safety
    /// No other thread touches the body's entry, if it moves.
    #[inline(always)]
    pub unsafe fn add_impulse(&self, sums: &Cells<Twist>, body: u32, impulse: &Twist) {
        let b = body as usize;
        if self.masses.inv_mass[b] > 0.0 {
            // SAFETY: the caller's promise.
            unsafe { sums.set(b, sums.get(b).plus(impulse)) };
        }
    }

    /// Add a block's impulse to the sums of its bodies.
    ///
    /// # Safety
    /// No other thread touches the entries of the block's moving bodies.
    #[inline(always)]
    pub unsafe fn add_block(&self, i: usize, d: DVec3, sums: &Cells<Twist>) {
        // SAFETY: the caller's promise.
        self.split(i, d, |body, linear, angular| unsafe {
            self.add_impulse(sums, body, &Twist { v: linear, w: angular })
        });
    }

    /// Zero sums of impulses for all bodies.
    pub fn clear_sums(&self, sums: &mut Vec<Twist>) {
        sums.clear();
        sums.resize(self.masses.inv_mass.len(), Twist::default());
    }

    /// Add the impulses of the blocks from `first` on to the sums of their bodies.
    pub fn add_blocks(&self, first: usize, gamma: &[DVec3], sums: &Cells<Twist>) {
        // The contacts, then their rolling blocks.
        for first in (first..gamma.len()).step_by(self.contacts.len().max(1)) {
            // SAFETY: contacts that are visited concurrently have no moving body in common.
            schedule::each(self.contacts, |contact| unsafe {
                self.add_block(first + contact, gamma[first + contact], sums)
            });
        }
    }

    /// Turn the sums of impulses in `out.twist` into velocities, and solve the joints.
    pub fn finish(&mut self, out: &mut Response) {
        let this = &*self;
        let [] = reduce_chunks(&mut out.twist, |first, rows| {
            // The sum of a body that is held in place is zero.
            let moved = |b: usize, sum: &Twist| this.free(b).plus(&this.masses.change::<false>(b, sum));
            rows.iter_mut().enumerate().for_each(|(k, t)| *t = moved(first + k, t));
            []
        });
        self.joints.reset(out);
        self.joints.solve(self.masses, out);
    }
}
