//! N = Dᵀ M̃⁻¹ D, matrix-free: each block gives its impulse to its two bodies, tile by tile (`state::Tiles`) and in a
//! fixed order, the joints answer, and the relative velocities are read block by block.
//!
//! Blocks: the contacts; then, where a material has rolling or spinning friction, a block of angular impulse for each contact;
//! then the limits of joints, one number each.

use super::joints::Joints;
use super::schedule::Colored;
use super::{Cells, Extrapolated, Image, Operator, Twist, descend, project_cone, schedule};
use crate::cpu::contact_solve::Masses;
use crate::cpu::{add, sum_rows, sweep, sweep_two};
use crate::joint::Row;
use crate::state::ContactLaw;
use crate::{Contacts, Model, State};
use glam::{DMat3, DVec3};

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
        if model.inv_mass[b] == 0.0 {
            return Twist::default();
        }
        Twist { v: state.velocity[b] + model.gravity * model.step, w: state.orientation[b] * state.angular_velocity[b] }
    }
}

/// The operator of a step.
pub struct BodyOperator<'a> {
    /// The contacts.
    pub contacts: &'a Contacts,
    /// The laws that their `law` points to.
    pub laws: &'a [ContactLaw],
    /// Masses in the world frame.
    pub masses: &'a Masses,
    /// Velocities without contacts and joints (n_bodies); none if they are those of bodies that fall.
    pub free: &'a [Twist],
    /// The bodies.
    pub falling: Falling<'a>,
    /// The joints.
    pub joints: &'a mut Joints,
    /// Limits of joints that may be met: dΨ/dt ≥ 0 once Ψ is 0.
    pub limits: &'a [Row],
    /// Normal part of b: Φ/h and what restitution asks (n_contacts + n_limits); none if it is Φ/h alone ([`Recovery`]).
    pub offset: &'a mut [f64],
    /// How overlaps are pushed apart.
    pub recovery: Recovery,
    /// The same without what exact friction feeds.
    pub offset_unfed: &'a [f64],
    /// η (n_blocks); none for sweeps over balls (`super::balls`), which have no use for it.
    pub eta: &'a [f64],
    /// Whether there are rolling blocks.
    pub rolls: bool,
    /// Whether contacts have friction alone: no cohesion.
    pub plain: bool,
    /// δ, m: cohesion reaches this far.
    pub envelope: f64,
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
    /// Φ/h, or as fast as an overlap may be pushed apart, m/s.
    #[inline]
    pub fn rate(&self, gap: f64) -> f64 {
        let rate = gap / self.step;
        if rate <= -self.speed { -self.speed } else { rate }
    }
}

/// What a block is.
enum Block {
    Contact(usize),
    Roll(usize),
    Limit(usize),
}

impl BodyOperator<'_> {
    #[inline]
    fn block(&self, i: usize) -> Block {
        let n = self.contacts.len();
        if i < n {
            Block::Contact(i)
        } else if self.rolls && i < 2 * n {
            Block::Roll(i - n)
        } else {
            Block::Limit(i - if self.rolls { 2 * n } else { n })
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
        match self.offset.get(contact) {
            Some(offset) => *offset,
            None => self.recovery.rate(self.contacts.gap[contact]),
        }
    }

    #[inline]
    fn law(&self, contact: usize) -> &ContactLaw {
        &self.laws[self.contacts.law[contact] as usize]
    }

    /// Relative velocity at a block, from motions.
    #[inline]
    fn relative(&self, i: usize, of: impl Fn(usize) -> Twist) -> DVec3 {
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
                DVec3::new(row.speed(a, b) + self.offset[self.contacts.len() + i], 0.0, 0.0)
            }
        }
    }

    /// Project a block; `gamma` reads a contact's impulse, on which the width of its rolling cone hangs.
    #[inline(always)]
    fn project_with(&self, i: usize, y: DVec3, gamma: impl Fn(usize) -> DVec3) -> DVec3 {
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
        self.free.get(body).copied().unwrap_or_else(|| self.falling.twist(body))
    }

    /// What a block's impulse gives to its bodies: `give(body, linear, angular)`.
    #[inline(always)]
    fn split(&self, i: usize, d: DVec3, give: impl Fn(u32, DVec3, DVec3)) {
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
    #[inline(always)]
    pub fn give(&self, sums: &Cells<Twist>, body: u32, impulse: &Twist) {
        let b = body as usize;
        if self.masses.inv_mass[b] > 0.0 {
            sums.set(b, sums.get(b).plus(impulse));
        }
    }

    /// Add a block's impulse to what its bodies are given.
    #[inline(always)]
    pub fn push(&self, i: usize, d: DVec3, sums: &Cells<Twist>) {
        self.split(i, d, |body, linear, angular| self.give(sums, body, &Twist { v: linear, w: angular }));
    }

    /// Nothing given to any body yet.
    fn nothing(&self, sums: &mut Vec<Twist>) {
        sums.clear();
        sums.resize(self.masses.inv_mass.len(), Twist::default());
    }

    /// Add the impulses of the blocks from `first` on.
    fn spread(&self, first: usize, gamma: &[DVec3], sums: &Cells<Twist>) {
        let limits = gamma.len() - self.limits.len()..gamma.len();
        // The contacts, then their rolling blocks.
        for first in (first..limits.start).step_by(self.contacts.len().max(1)) {
            schedule::each(self.contacts, |contact| self.push(first + contact, gamma[first + contact], sums));
        }
        limits.for_each(|i| self.push(i, gamma[i], sums));
    }

    /// The velocity of a body that has been given impulses.
    #[inline(always)]
    fn moved(&self, body: usize, free: &Twist, sum: &Twist) -> Twist {
        // One that is held in place has been given nothing.
        Twist { v: free.v + sum.v * self.masses.inv_mass[body], w: free.w + self.masses.turn(body, sum.w) }
    }

    /// Make velocities of what bodies have been given, and let the joints answer.
    fn finish(&mut self, out: &mut Image) {
        let this = &*self;
        let [] = sweep(&mut out.twist, |first, rows| {
            rows.iter_mut().enumerate().for_each(|(k, t)| *t = this.moved(first + k, &this.free(first + k), t));
            []
        });
        out.lambda.clear();
        self.joints.answer(self.masses, out);
    }
}

impl Operator for BodyOperator<'_> {
    fn n_blocks(&self) -> usize {
        self.contacts.len() * if self.rolls { 2 } else { 1 } + self.limits.len()
    }

    fn image(&mut self, gamma: &[DVec3], out: &mut Image) {
        self.nothing(&mut out.twist);
        self.spread(0, gamma, &Cells::new(&mut out.twist));
        self.finish(out);
    }

    #[inline]
    fn pull(&self, image: &Image, i: usize) -> DVec3 {
        self.relative(i, |b| image.twist[b])
    }

    fn curvature(&self, a: &Image, b: &Image) -> f64 {
        let energy = |i: usize| [self.masses.energy(i, &a.twist[i].minus(&b.twist[i]))];
        sum_rows(self.masses.inv_mass.len(), energy)[0] + self.joints.compliance(&a.lambda, &b.lambda)
    }

    fn energy(&self, image: &Image) -> f64 {
        let [energy] = sum_rows(self.masses.inv_mass.len(), |b| [self.masses.energy(b, &image.twist[b])]);
        energy + self.joints.compliance(&image.lambda, &vec![0.0; image.lambda.len()])
    }

    fn descend(&self, next: &mut [DVec3], from: &Extrapolated, step: f64, to: &mut Image) -> [f64; 2] {
        if !self.plain {
            return sweep(next, |first, rows| descend::any(self, first, rows, from, step));
        }
        self.nothing(&mut to.twist);
        let sums = Cells::new(&mut to.twist);
        let n = self.contacts.len();
        let (own, others) = next.split_at_mut(n);
        let done = descend::contacts(self, own, from, step, &sums);
        let rest = sweep(others, |first, rows| descend::any(self, n + first, rows, from, step));
        self.spread(n, next, &sums);
        add(done, rest)
    }

    fn advance(&mut self, next: &[DVec3], beta: f64, [x, y]: [&Image; 2], [to, to_y]: [&mut Image; 2]) -> f64 {
        if !self.plain {
            return descend::advance(self, next, beta, [x, y], [to, to_y]);
        }
        if !self.joints.rows.is_empty() {
            self.finish(to);
            to_y.extrapolate(to, x, beta);
            return self.curvature(to, y);
        }
        // Without joints one pass over the bodies does it all.
        to_y.twist.resize(to.twist.len(), Twist::default());
        let this = &*self;
        let [curvature] = sweep_two(&mut to.twist, &mut to_y.twist, |first, to, to_y| {
            let mut sum = 0.0;
            for (k, (to, to_y)) in to.iter_mut().zip(to_y).enumerate() {
                let b = first + k;
                let (new, x, y) = (this.moved(b, &this.free[b], to), &x.twist[b], &y.twist[b]);
                *to = new;
                *to_y = new.beyond(x, beta);
                sum += this.masses.energy(b, &new.minus(y));
            }
            [sum]
        });
        curvature
    }

    #[inline]
    fn project(&self, i: usize, y: DVec3, gamma: &[DVec3]) -> DVec3 {
        self.project_with(i, y, |i| gamma[i])
    }

    fn project_cells(&self, i: usize, y: DVec3, gamma: &Cells<DVec3>) -> DVec3 {
        self.project_with(i, y, |i| gamma.get(i))
    }

    #[inline]
    fn eta(&self, i: usize) -> f64 {
        self.eta[i]
    }

    /// The radius of gyration √(η_roll/η_contact) of a rolling block.
    #[inline]
    fn lever(&self, i: usize) -> f64 {
        match self.block(i) {
            Block::Roll(contact) => (self.eta[i] / self.eta[contact]).sqrt(),
            _ => 1.0,
        }
    }

    fn diagonal(&self, i: usize) -> DMat3 {
        let masses = self.masses;
        match self.block(i) {
            Block::Contact(i) => {
                let [a, b] = self.contacts.bodies[i].map(|b| b as usize);
                let [arm_a, arm_b] = self.contacts.arms(i);
                let cross =
                    |arm: DVec3| DMat3::from_cols(arm.cross(DVec3::X), arm.cross(DVec3::Y), arm.cross(DVec3::Z));
                let turned = |b: usize, arm: DVec3| {
                    let c = cross(arm);
                    c.transpose() * masses.inertia(b) * c
                };
                DMat3::from_diagonal(DVec3::splat(masses.inv_mass[a] + masses.inv_mass[b]))
                    + turned(a, arm_a)
                    + turned(b, arm_b)
            }
            Block::Roll(i) => {
                let [a, b] = self.contacts.bodies[i].map(|b| b as usize);
                masses.inertia(a) + masses.inertia(b)
            }
            Block::Limit(_) => DMat3::from_diagonal(DVec3::splat(1.0 / self.eta[i])),
        }
    }

    fn kick(&self, cells: &Cells<Twist>, i: usize, d: DVec3) {
        let masses = self.masses;
        self.split(i, d, |body, linear, angular| {
            let b = body as usize;
            if masses.inv_mass[b] > 0.0 {
                let t = cells.get(b);
                cells.set(b, Twist { v: t.v + linear * masses.inv_mass[b], w: t.w + masses.turn(b, angular) });
            }
        });
    }

    fn pull_cells(&self, cells: &Cells<Twist>, i: usize) -> DVec3 {
        self.relative(i, |b| cells.get(b))
    }

    fn settle(&mut self, image: &mut Image) {
        self.joints.answer(self.masses, image);
    }

    fn colors(&self, colored: &mut Colored) {
        let moving = |body: u32| (self.masses.inv_mass[body as usize] > 0.0).then_some(body);
        let bodies = |i: u32| match self.block(i as usize) {
            Block::Contact(i) | Block::Roll(i) => self.contacts.bodies[i].map(moving),
            Block::Limit(i) => self.limits[i].bodies.map(moving),
        };
        let mut taken = vec![0; self.masses.inv_mass.len()];
        colored.fill(0..self.n_blocks() as u32, bodies, &Cells::new(&mut taken));
    }

    fn has_open_cones(&self) -> bool {
        self.plain
    }

    fn has_cones_apart(&self) -> bool {
        !self.rolls
    }

    fn friction(&self, i: usize) -> (f64, DVec3) {
        match self.block(i) {
            Block::Contact(i) => (self.law(i).friction, self.contacts.normal[i]),
            _ => (0.0, DVec3::ZERO),
        }
    }

    fn feed(&mut self, slip: &[f64]) {
        for i in 0..self.contacts.len() {
            self.offset[i] = self.offset_unfed[i] + slip[i];
        }
    }
}
