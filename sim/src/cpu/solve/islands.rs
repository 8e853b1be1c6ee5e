//! Islands of slow bodies, each solved as a whole. What stands on each other sways in modes that sweeps hardly see: those of a column of
//! n boxes take in the order of n⁴ sweeps, and what is left of them has the column sway on.
//!
//! An interior point method for the convex problem of the velocities: with z and s, impulses and velocities of the contacts in
//! coordinates in which their cones are those of Lorentz, it follows the path z ∘ s = τ (1, 0, 0) to τ = 0 by Mehrotra's predictor and corrector in
//! the scaling of Nesterov and Todd, in some ten steps whatever the modes. The matrix of a step, M + Dᵀ K D with a block K of each contact,
//! has six rows a body and is factorised by nested dissection ([`super::sparse`]).
//! Source: Vandenberghe, *The CVXOPT linear and quadratic cone program solvers* (2010); for granular contacts Kleinert, Simeon and
//! Obermayr, *An inexact interior point method for the large-scale simulation of granular material* (2014).

use super::bodies::BodyOperator;
use super::cone::project_cone;
use super::lorentz::{Scaling, longest, product, quotient};
use super::operator::Operator;
use super::residual::term_of;
use super::response::Response;
use super::schedule::Blocks;
use super::slip;
use super::sparse::{Factor, Front, Structure, dissection};
use crate::contacts::tangents;
use crate::disjoint_sets::DisjointSets;
use crate::twist::Twist;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// Steps, at most.
const STEPS: usize = 40;
/// The share of the way to the edge of a cone that a step goes, at most.
const SHORT: f64 = 0.99;
/// How far from the edges of the cones the start is, over the speed of a step of free fall.
const INTERIOR: f64 = 0.1;
/// Compliance of contacts over their response: of the impulses that the velocities leave open, those near the start are found. With a
/// hundredth of it contacts press each other by many times their load, and each that comes or goes is a kick.
const COMPLIANCE: f64 = 1e-4;
/// zᵀs over that of the start at which rounding may end the path.
const NEAR: f64 = 1e-6;
/// Friction below which it is taken as this.
const LEAST_FRICTION: f64 = 1e-6;
/// Solves with the slip of the one before fed back, at most, for the exact law.
const SLIPS: usize = 4;
/// Multiplications of a factorisation for each contact of an island, at most.
const WORK: u64 = 4000;
/// Bodies of an island, at most.
const MOST_BODIES: usize = 512;
/// Bodies of a model up to which all islands are looked at; of more only those in tiles without a fast body, since looking takes a thirtieth of the
/// step of thousands that fall.
const FEW_BODIES: usize = 2048;
/// Bodies of an island for each that takes part in its motion, at most: a cone that rolls on a bed at rest moves alone, which sweeps see, and would have
/// the bed solved in each step.
const OF_EACH: usize = 32;
/// Speed from which on a body takes part in the motion of its island, over that of its fastest body.
const TAKES_PART: f64 = 0.1;

/// Contacts of slow bodies, in whose islands all that touches is solved, and how well.
pub struct Slow<'a> {
    /// Blocks that are known to be unsettled.
    pub blocks: Vec<u32>,
    /// The blocks of the step.
    pub all: &'a Blocks,
    /// The error of the velocities that is allowed, and the residual of contacts in the root mean square, m/s.
    pub error: f64,
    /// The speeds between which the fastest body of an island is where it is solved, m/s: slower ones come to rest as it is, faster ones are
    /// still to fall on what they will stand on. What all of an island moves sideways does not count as fast: a stack on a sled is as slow as one on
    /// the ground.
    pub speeds: [f64; 2],
    /// Whether the law of friction is the exact one.
    pub is_exact: bool,
}

/// What is known of the bodies of an island.
#[derive(Clone, Copy, Default)]
struct Group {
    n_bodies: usize,
    /// Sum of their velocities, m/s.
    sum: DVec3,
    /// Their greatest speed, and the greatest beside what all of them move sideways, squared, m²/s².
    fastest: [f64; 2],
    /// The number of those that take part in its motion.
    n_moving: usize,
}

/// Solve the islands of the slow contacts: bodies that hang together by contacts, all of them, since pieces that are solved apart from what they
/// stand on make the rest sway. The impulses come in as what is found so
/// far, with the velocities that they lead to; better ones go out. Returns whether there are any.
pub fn solve(op: &BodyOperator, slow: &Slow, gamma: &mut [DVec3], response: &Response) -> bool {
    let now = &*gamma;
    let twist = &response.twist[..];
    let solved: Vec<Option<Island>> = islands(op, slow, now, response)
        .into_par_iter()
        .with_max_len(1)
        .map(|(bodies, blocks)| {
            let mut island = Island::new(op, slow.all, (bodies, &blocks), (now, twist));
            island.solve(op, slow).then_some(island)
        })
        .collect();
    let is_any = solved.iter().any(|island| island.is_some());
    for c in solved.iter().flatten().flat_map(|island| &island.contacts) {
        gamma[c.id as usize] = c.impulse();
    }
    is_any
}

/// The moving bodies and the blocks of each island that is slow, but not settled, and can be solved.
fn islands(op: &BodyOperator, slow: &Slow, gamma: &[DVec3], response: &Response) -> Vec<(Vec<u32>, Vec<u32>)> {
    const NONE: u32 = u32::MAX;
    let twist = &response.twist[..];
    let [least, most] = slow.speeds.map(|speed| speed * speed);
    if twist.iter().all(|t| t.v.length_squared() <= least) {
        return vec![];
    }
    let n_bodies = op.masses.inv_mass.len();
    if slow.blocks.is_empty() && n_bodies > FEW_BODIES {
        return vec![];
    }
    let moves = |b: &u32| op.masses.inv_mass[*b as usize] > 0.0;
    let ends = |block: u32| op.contacts.bodies[slow.all.contacts(block).start];
    let of_one = |block: u32| ends(block).into_iter().find(moves);
    let mut sets = DisjointSets::new(n_bodies);
    (0..slow.all.n_manifolds()).map(ends).filter(|ends| ends.iter().all(moves)).for_each(|ends| sets.join(ends));
    let groups = groups(op, &mut sets, twist);
    let can_be = |group: &Group| {
        group.n_bodies <= MOST_BODIES
            && group.n_bodies <= OF_EACH * group.n_moving
            && group.fastest[0] > least
            && group.fastest[1] <= most
    };
    if !groups.iter().any(can_be) {
        return vec![];
    }
    // The place of each island by its lowest body.
    let mut place = vec![NONE; n_bodies];
    let mut islands: Vec<(Vec<u32>, Vec<u32>)> = vec![];
    for block in 0..slow.all.n_manifolds() {
        let Some(island) = of_one(block).map(|b| sets.of(b) as usize) else { continue };
        if !can_be(&groups[island]) {
            continue;
        }
        if place[island] == NONE {
            place[island] = islands.len() as u32;
            islands.push(Default::default());
        }
        islands[place[island] as usize].1.push(block);
    }
    for b in (0..n_bodies as u32).filter(moves) {
        if let Some((bodies, _)) = islands.get_mut(place[sets.of(b) as usize] as usize) {
            bodies.push(b);
        }
    }
    let mut is_known = vec![false; islands.len()];
    for b in slow.blocks.iter().filter_map(|block| of_one(*block)) {
        if let Some(is_known) = is_known.get_mut(place[sets.of(b) as usize] as usize) {
            *is_known = true;
        }
    }
    let is_unsettled = |blocks: &[u32]| {
        let contacts = || blocks.iter().flat_map(|block| slow.all.contacts(*block));
        let left = |i: usize| left(op, i, slow.is_exact, gamma, response).length_squared();
        n_bodies <= FEW_BODIES
            && contacts().map(left).sum::<f64>() > slow.error * slow.error * contacts().count() as f64
    };
    let found = islands.into_iter().zip(is_known);
    found.filter(|((_, blocks), is_known)| *is_known || is_unsettled(blocks)).map(|(island, _)| island).collect()
}

/// What is left of a contact ([`super::residual::term`]), by the exact law with the slip that it has.
fn left(op: &BodyOperator, i: usize, is_exact: bool, gamma: &[DVec3], response: &Response) -> DVec3 {
    let gradient = op.gradient(response, i);
    let slip = if is_exact { slip::of_block(op, i, gradient) } else { 0.0 };
    term_of(op, i, op.masses.eta(op.contacts, i), gamma, gradient + op.contacts.normal[i] * slip)
}

/// The bodies that hang together, each set by its lowest body.
fn groups(op: &BodyOperator, sets: &mut DisjointSets, twist: &[Twist]) -> Vec<Group> {
    let moving = |b: &usize| op.masses.inv_mass[*b] > 0.0;
    let mut groups = vec![Group::default(); twist.len()];
    for b in (0..twist.len()).filter(moving) {
        let group = &mut groups[sets.of(b as u32) as usize];
        group.n_bodies += 1;
        group.sum += twist[b].v;
    }
    for b in (0..twist.len()).filter(moving) {
        let group = &mut groups[sets.of(b as u32) as usize];
        let mean = group.sum / group.n_bodies as f64;
        let sideways = mean - op.down * mean.dot(op.down);
        let speeds2 = [twist[b].v, twist[b].v - sideways].map(|v| v.length_squared());
        group.fastest = [0, 1].map(|k| group.fastest[k].max(speeds2[k]));
    }
    for b in (0..twist.len()).filter(moving) {
        let group = &mut groups[sets.of(b as u32) as usize];
        group.n_moving += usize::from(twist[b].v.length_squared() > TAKES_PART * TAKES_PART * group.fastest[0]);
    }
    groups
}

/// A contact of an island. Its cone is made that of Lorentz: z = (μ γ_n, γ_t) and s = (u_n/μ, u_t), with u = v + b.
struct Contact {
    /// Its place among all contacts.
    id: u32,
    /// Rows: the normal over μ, and the tangents.
    frame: DMat3,
    arms: [DVec3; 2],
    /// A third of the trace of N_ii, 1/kg.
    response: f64,
    friction: f64,
    /// The impulse at the start, N s, world.
    first: DVec3,
    /// s and z at the start, m/s and N s.
    start: DVec3,
    anchor: DVec3,
    /// The diagonal of E, by which s gives way to what z differs from the anchor, 1/kg.
    compliance: DVec3,
    /// The slip that is fed back to s by the exact law, m/s.
    slip: f64,
    z: DVec3,
    s: DVec3,
    step: Step,
}

/// What belongs to a contact in a step of the method.
#[derive(Default)]
struct Step {
    /// s without what the velocities make it, m/s.
    infeasible: DVec3,
    /// W, for which W z = W⁻¹ s, K = (W² + E)⁻¹, and λ = W z.
    scaling: Scaling,
    stiffness: DMat3,
    lambda: DVec3,
    /// What W dz + W⁻¹ ds is to be.
    towards: DVec3,
    dz: DVec3,
    ds: DVec3,
}

impl Contact {
    fn new(op: &BodyOperator, i: usize, gamma: DVec3, twist: &[Twist]) -> Contact {
        let (arms, normal) = (op.contacts.arms(i), op.contacts.normal[i]);
        let friction = op.law(i).friction.max(LEAST_FRICTION);
        let (u, w) = tangents(normal);
        let frame = DMat3::from_cols(normal / friction, u, w).transpose();
        let response = op.masses.trace(op.contacts.bodies[i].map(|b| b as usize), arms) / 3.0;
        let compliance = COMPLIANCE * response * DVec3::new(friction.powi(-2), 1.0, 1.0);
        let along = frame * gamma;
        Contact {
            id: i as u32,
            frame,
            arms,
            response,
            friction,
            first: gamma,
            start: frame * op.relative(i, |b| twist[b]),
            anchor: DVec3::new(along.x * friction * friction, along.y, along.z),
            compliance,
            slip: 0.0,
            z: DVec3::ZERO,
            s: DVec3::ZERO,
            step: Step::default(),
        }
    }

    /// Put z and s where the method starts from: near the impulse and the velocity of the start, within the cones by some room, m/s.
    fn begin(&mut self, room: f64) {
        /// A vector moved along the axis of the cone so far that it is within it by some room.
        fn within(x: DVec3, room: f64) -> DVec3 {
            let least = x.x - (x.y * x.y + x.z * x.z).sqrt();
            x + DVec3::X * (room - least).max(0.0)
        }
        self.z = within(self.anchor, room / self.response);
        self.s = within(self.start + DVec3::X * self.slip, room);
    }

    /// The change of s by changes of the two bodies' velocities.
    fn moved(&self, [a, b]: [Twist; 2]) -> DVec3 {
        self.frame * (b.v + b.w.cross(self.arms[1]) - a.v - a.w.cross(self.arms[0]))
    }

    /// Add an impulse, N s, world, to the sums of the bodies that move.
    fn push(&self, impulse: DVec3, ends: &Ends, sums: &mut [Twist]) {
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            if let Some(b) = ends[side] {
                let sum = &mut sums[b as usize];
                sum.v += impulse * sign;
                sum.w += self.arms[side].cross(impulse) * sign;
            }
        }
    }

    /// The impulse, N s, world, in its cone: a step of the projection from what is found on, by which contacts that open have none.
    fn impulse(&self) -> DVec3 {
        let f = self.friction;
        let [normal, u, w] = [self.frame.row(0) * f, self.frame.row(1), self.frame.row(2)];
        let gamma = DVec3::new(self.z.x / f, self.z.y, self.z.z);
        let next = gamma - DVec3::new(self.s.x * f, self.s.y, self.s.z) / self.response;
        project_cone(normal * next.x + u * next.y + w * next.z, normal, f)
    }
}

/// The bodies of a block that move, by their places among those of the island.
type Ends = [Option<u32>; 2];

/// The twists of a block's bodies, of bodies' ones.
fn of_ends(twist: &[Twist], ends: &Ends) -> [Twist; 2] {
    ends.map(|b| b.map_or(Twist::default(), |b| twist[b as usize]))
}

/// An island: bodies that move, and contacts between them and with what does not move.
struct Island {
    /// The contacts of each block, and its bodies.
    blocks: Vec<(Range<usize>, Ends)>,
    contacts: Vec<Contact>,
    /// Masses and inertia tensors, kg and kg m².
    mass: Vec<(f64, DMat3)>,
    /// The change of the velocities.
    change: Vec<Twist>,
}

impl Island {
    fn new(
        op: &BodyOperator,
        all: &Blocks,
        (bodies, blocks): (Vec<u32>, &[u32]),
        (gamma, twist): (&[DVec3], &[Twist]),
    ) -> Island {
        let place = |b: u32| bodies.binary_search(&b).ok().map(|k| k as u32);
        let mut contacts = vec![];
        let of_block = |block: &u32| {
            let (first, own) = (contacts.len(), all.contacts(*block));
            let ends = op.contacts.bodies[own.start].map(place);
            contacts.extend(own.map(|i| Contact::new(op, i, gamma[i], twist)));
            (first..contacts.len(), ends)
        };
        let blocks = blocks.iter().map(of_block).collect();
        let mass = |b: &u32| (1.0 / op.masses.inv_mass[*b as usize], op.masses.inertia(*b as usize));
        let change = vec![Twist::default(); bodies.len()];
        Island { blocks, contacts, mass: bodies.iter().map(mass).collect(), change }
    }

    /// The contacts with the bodies of their blocks.
    fn each(&mut self, mut visit: impl FnMut(&mut Contact, &Ends)) {
        for (range, ends) in &self.blocks {
            self.contacts[range.clone()].iter_mut().for_each(|c| visit(c, ends));
        }
    }

    /// Solve. Returns whether it is solved, by the exact law to its slip.
    fn solve(&mut self, op: &BodyOperator, slow: &Slow) -> bool {
        let n = self.mass.len();
        let ends: Vec<Ends> = self.blocks.iter().map(|(_, ends)| *ends).collect();
        // The elements of the matrix: the bodies, and the blocks.
        let mut elements: Vec<Vec<u32>> = (0..n as u32).map(|b| vec![b]).collect();
        elements.extend(ends.iter().map(|ends| ends.iter().flatten().copied().collect()));
        let mut factor = Factor::new(Structure::analyse(&vec![6; n], n, &dissection(n, &ends), &mut elements));
        if factor.work() > WORK * self.contacts.len() as u64 {
            return false;
        }
        for _ in 0..if slow.is_exact { SLIPS } else { 1 } {
            self.contacts.iter_mut().for_each(|c| c.begin(INTERIOR * op.least_slip));
            if !self.follow_path((&mut factor, &elements), slow.error) {
                return false;
            }
            let mut most = 0.0f64;
            for c in &mut self.contacts {
                let slip = (c.s.y * c.s.y + c.s.z * c.s.z).sqrt();
                most = most.max(c.friction * (slip - c.slip).abs());
                c.slip = slip;
            }
            if most <= slow.error {
                return true;
            }
        }
        !slow.is_exact
    }

    /// Follow the path to its end. Returns whether the velocities are within an error, m/s.
    fn follow_path(&mut self, (factor, elements): (&mut Factor, &[Vec<u32>]), error: f64) -> bool {
        let lightest = self.mass.iter().map(|(mass, _)| *mass).fold(f64::INFINITY, f64::min);
        // ½ |v − v*|² in the metric M is at most zᵀs.
        let enough = 0.5 * lightest * error * error;
        let n_contacts = self.contacts.len() as f64;
        let (mut first, mut last) = (0.0f64, f64::INFINITY);
        for _ in 0..STEPS {
            let (gap, infeasible) = self.measure();
            first = first.max(gap);
            let is_near = gap <= NEAR * first && infeasible <= error;
            if gap <= enough && infeasible <= error || is_near && gap > 0.5 * last {
                return true;
            }
            last = gap;
            for c in &mut self.contacts {
                let scaling = Scaling::new(c.z, c.s);
                let lambda = scaling.apply(c.z);
                let stiffness = (scaling.square() + DMat3::from_diagonal(c.compliance)).inverse();
                c.step = Step { stiffness, lambda, towards: -lambda, scaling, ..c.step };
            }
            self.factorise(factor, elements);
            // To the end; then as far along the path as that would have come.
            self.find_step(factor);
            let t = self.longest_step().min(1.0);
            let after = |c: &Contact| (c.z + c.step.dz * t).dot(c.s + c.step.ds * t);
            let left = self.contacts.iter().map(after).sum::<f64>() / gap;
            let target = DVec3::X * (left.clamp(0.0, 1.0).powi(3) * gap / n_contacts);
            for c in &mut self.contacts {
                let Step { scaling, lambda, ds, dz, .. } = &c.step;
                let of_second_order = product(scaling.apply(*dz), scaling.apply_inverse(*ds));
                c.step.towards = quotient(*lambda, target - product(*lambda, *lambda) - of_second_order);
            }
            let change = self.find_step(factor);
            if !change.iter().all(|d| d.v.is_finite() && d.w.is_finite()) {
                return is_near;
            }
            let t = (SHORT * self.longest_step()).min(1.0);
            for (sum, d) in self.change.iter_mut().zip(&change) {
                *sum = Twist { v: sum.v + d.v * t, w: sum.w + d.w * t };
            }
            for c in &mut self.contacts {
                (c.s, c.z) = (c.s + c.step.ds * t, c.z + c.step.dz * t);
            }
        }
        false
    }

    /// zᵀs, J; and how far an s is from what the velocities make it, m/s.
    fn measure(&mut self) -> (f64, f64) {
        let change = std::mem::take(&mut self.change);
        let (mut gap, mut most) = (0.0, 0.0f64);
        self.each(|c, ends| {
            c.step.infeasible =
                c.s - c.start - DVec3::X * c.slip - c.moved(of_ends(&change, ends)) - c.compliance * (c.z - c.anchor);
            gap += c.z.dot(c.s);
            most = most.max(c.step.infeasible.length_squared());
        });
        self.change = change;
        (gap, most.sqrt())
    }

    /// The longest step that stays in the cones.
    fn longest_step(&self) -> f64 {
        let of = |c: &Contact| longest(c.s, c.step.ds).min(longest(c.z, c.step.dz));
        self.contacts.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Find ds and dz of the contacts for what they are to go towards. Returns the changes of the velocities.
    fn find_step(&mut self, factor: &mut Factor) -> Vec<Twist> {
        let inertial = |((mass, inertia), c): (&(f64, DMat3), &Twist)| Twist { v: c.v * -*mass, w: *inertia * -c.w };
        let mut sums: Vec<Twist> = self.mass.iter().zip(&self.change).map(inertial).collect();
        self.each(|c, ends| {
            let Step { scaling, stiffness, towards, infeasible, .. } = &c.step;
            let z = c.z + *stiffness * (scaling.apply(*towards) + *infeasible);
            c.push(c.frame.transpose() * z - c.first, ends, &mut sums);
        });
        let first: Vec<usize> = factor.first().iter().map(|first| *first as usize).collect();
        let x = factor.rows();
        x.fill(0.0);
        for (at, sum) in first.iter().zip(&sums) {
            x[*at..at + 3].copy_from_slice(&sum.v.to_array());
            x[at + 3..at + 6].copy_from_slice(&sum.w.to_array());
        }
        factor.solve();
        let x = factor.rows();
        let twist = |at: &usize| Twist { v: DVec3::from_slice(&x[*at..]), w: DVec3::from_slice(&x[at + 3..]) };
        let change: Vec<Twist> = first.iter().map(twist).collect();
        self.each(|c, ends| {
            let moved = c.moved(of_ends(&change, ends)) - c.step.infeasible;
            c.step.dz = c.step.stiffness * (c.step.scaling.apply(c.step.towards) - moved);
            c.step.ds = moved + c.compliance * c.step.dz;
        });
        change
    }

    /// Factorise M + Dᵀ K D, K = Fᵀ (W² + E)⁻¹ F with the frames F.
    fn factorise(&self, factor: &mut Factor, elements: &[Vec<u32>]) {
        let n = self.mass.len();
        factor.factorise(f64::MIN_POSITIVE, |front, e, at| match e.checked_sub(n) {
            None => self.add_mass(front, e, at[0] as usize),
            Some(block) => self.add_block(front, block, (at, &elements[e])),
        });
    }

    /// Add the mass and the inertia tensor of a body, whose first row is `at`.
    fn add_mass(&self, front: &mut Front, body: usize, at: usize) {
        let (mass, inertia) = &self.mass[body];
        for i in 0..3 {
            front.row(at + i).add(at + i, *mass);
            let mut row = front.row(at + 3 + i);
            (0..=i).for_each(|j| row.add(at + 3 + j, inertia.col(j)[i]));
        }
    }

    /// Add Dᵀ K D of the contacts of a block; `at` are the first rows of its bodies, in the order of `element`.
    fn add_block(&self, front: &mut Front, block: usize, (at, element): (&[u32], &[u32])) {
        let (range, ends) = &self.blocks[block];
        let side = |b: &u32| if ends[0] == Some(*b) { 0 } else { 1 };
        // The velocity at a contact is v + X w of each body, with X w = w × r: sums of K, K X, and Xᵀ K X.
        let sides: [usize; 2] = std::array::from_fn(|p| element.get(p).map_or(0, side));
        let mut linear = DMat3::ZERO;
        let mut mixed = [DMat3::ZERO; 2];
        let mut angular = [[DMat3::ZERO; 2]; 2];
        for c in &self.contacts[range.clone()] {
            let k = c.frame.transpose() * c.step.stiffness * c.frame;
            linear += k;
            for q in 0..element.len() {
                let r = c.arms[sides[q]];
                let k_x = DMat3::from_cols(
                    k.z_axis * r.y - k.y_axis * r.z,
                    k.x_axis * r.z - k.z_axis * r.x,
                    k.y_axis * r.x - k.x_axis * r.y,
                );
                mixed[q] += k_x;
                for p in q..element.len() {
                    let cross = |column: DVec3| c.arms[sides[p]].cross(column);
                    angular[p][q] += DMat3::from_cols(cross(k_x.x_axis), cross(k_x.y_axis), cross(k_x.z_axis));
                }
            }
        }
        // Parts of three rows of the bodies, of v and of w, by those of three columns.
        let mut sum = [[DMat3::ZERO; 4]; 4];
        for p in 0..element.len() {
            for q in 0..=p {
                let sign = if p == q { 1.0 } else { -1.0 };
                sum[2 * p][2 * q] = linear * sign;
                sum[2 * p][2 * q + 1] = mixed[q] * sign;
                sum[2 * p + 1][2 * q] = mixed[p].transpose() * sign;
                sum[2 * p + 1][2 * q + 1] = angular[p][q] * sign;
            }
        }
        for p in 0..2 * element.len() {
            for r in 0..3 {
                let mut row = front.row(at[p / 2] as usize + p % 2 * 3 + r);
                for q in 0..=p {
                    let n_columns = if p == q { r + 1 } else { 3 };
                    (0..n_columns).for_each(|k| row.add(at[q / 2] as usize + q % 2 * 3 + k, sum[p][q].col(k)[r]));
                }
            }
        }
    }
}
