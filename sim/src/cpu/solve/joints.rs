//! Elimination of the joints: impulses f change the velocities by `M⁻¹f`, and the joints are solved for the multipliers λ that
//! satisfy `Bᵀv + Ψ/h + ∂Ψ/∂t + Cλ = 0`, by a sparse factorisation of `S = BᵀM⁻¹B + C`.
//!
//! The projected iteration over contacts then works with `M̃⁻¹ = M⁻¹ − M⁻¹B S⁻¹ BᵀM⁻¹` in place of M⁻¹: a chain of stiff joints
//! with light links and a heavy load costs it no iterations. (The paper iterates over joints and contacts alike, and names
//! the slow convergence as its open problem, §6.)
//!
//! All rows of a body are coupled in S, those of a hub, a body with very many joints, too many: its velocities u stay unknowns, with the
//! rows `Bᵀλ − M u = 0` of their own, which are eliminated last.
//!
//! C has the compliance of springs, and for rigid rows a small fraction of the diagonal, which regularises redundant rows.

mod lasting;
mod limits_that_hold;

use super::limits::Limits;
use super::motors::{Motor, Motors};
use super::pivoting::{Next, Rounds, Wrong};
use super::response::Response;
use super::sparse::{self, Factor, Front, Structure};
use crate::cpu::masses::Masses;
use crate::disjoint_sets::DisjointSets;
use crate::joint::Row;
use crate::joint_factor::{Factorised, JointFactor};
use crate::twist::Twist;
use glam::DMat3;
use std::sync::Arc;

pub use super::sparse::Phases;

/// Compliance of a rigid row, relative to its diagonal. It distributes the load over redundant rows (two pins of a hinge, a closed ring
/// of hinges); a chain that carries a thousand times its links' weight gives way by some 10⁻⁸ m. What it gives way by, it gives back: straight bridges
/// spring by it.
const REGULARIZATION: f64 = 1e-6;

/// The same of a limit: it holds against a motor without a maximum, and a beam of hinges at their limits does not spring.
const REGULARIZATION_OF_LIMITS: f64 = 1e-9;

/// The rows of a step and their factorisation.
#[derive(Default)]
pub struct Joints {
    /// The rows.
    pub rows: Vec<Row>,
    /// `Ψ/h + ∂Ψ/∂t` and the terms of springs, m/s or rad/s (n_rows).
    pub bias: Vec<f64>,
    /// What part of a whole step the step is: rigid rows give way by as much as in that.
    pub part: f64,
    /// What the step leaves of Ψ, m or rad (n_rows).
    pub kept: Vec<f64>,
    /// Whether their bodies are light links under heavy loads.
    pub is_light: bool,
    /// Whether geometric stiffness acts on their bodies.
    pub is_stiff: bool,
    /// Motors with a maximum effort.
    pub motors: Motors,
    /// Limits that may be met, whose rows are the last of their joints.
    pub limits: Limits,
    /// The rounds of the step, and the bias of rows that are linear, from which each begins ([`super::pivoting`]).
    rounds: Rounds,
    linear_bias: Vec<f64>,
    /// Whether the factor is that of the rows as they are now: the next to factorise them need not.
    pub is_factorised: bool,
    /// Whether a body has rows (n_bodies).
    is_held: Vec<bool>,
    pattern: Pattern,
    factor: Factor,
    softness: Vec<f64>,
    /// Whether the structure of the factor has changed since it was last asked ([`Joints::take_is_new`]).
    is_new: bool,
    /// What the factor is of, where it lasts.
    of: Option<Arc<Factorised>>,
    /// Whether that is an earlier step.
    is_old: bool,
    lasting: JointFactor,
    /// Solves of the step, and the greatest |rate| that was left to the first of them, m/s or rad/s.
    n_solves: usize,
    first_left: f64,
}

/// Pivot over the diagonal below which a row follows from those before it: thirty times the trace of compliance that lets it be there at
/// all. Single precision would lose the others in the great numbers of its inverse.
const DEPENDENT: f64 = 3e-5;

/// The rows of a step and their factorisation for single precision: what they let the bodies do is the same, but rows that follow from
/// others have no multipliers.
#[derive(Default)]
pub struct Reduced {
    /// The factor.
    pub factor: Factor,
    /// Compliance of the rows, 1/kg or 1/(kg m²) (n_rows).
    pub softness: Vec<f64>,
    /// The least pivot over its diagonal of the other rows.
    pub weakest: f64,
}

/// The sparsity pattern: rows that act on the same moving bodies are a group.
#[derive(Default)]
struct Pattern {
    /// Bodies of the rows when the pattern was analysed (n_rows).
    bodies: Vec<[u32; 2]>,
    /// Moving bodies of the groups, the lower first, and [`NONE`] in place of one (n_groups, ascending).
    groups: Vec<[u32; 2]>,
    /// The groups in the order of elimination, which follows from their bodies alone.
    order: Vec<u32>,
    /// Rows of each group: starts (n_groups + 1), rows.
    row_start: Vec<u32>,
    row: Vec<u32>,
    /// The moving bodies that have rows, ascending.
    held: Vec<u32>,
    /// The mechanism of each of these: bodies that rows connect have the same number (n_held).
    mechanism: Vec<u32>,
    /// Hubs, whose velocities are groups too, after those of the rows.
    hubs: Vec<u32>,
    /// Parts of S: their bodies and groups.
    parts: Vec<u32>,
    groups_of: Vec<Vec<u32>>,
    /// Place of each row among the rows of the factor (n_rows).
    place: Vec<u32>,
}

/// In place of a second moving body.
const NONE: u32 = u32::MAX;

/// Groups above which a body may be a hub, and the most hubs that there are.
const HUB: usize = 24;
const MOST_HUBS: usize = 64;

/// A row's Jacobian on one of its bodies.
pub fn on_body(row: &Row, body: u32) -> Twist {
    if row.bodies[1] == body {
        Twist { v: row.linear, w: row.angular_b }
    } else {
        Twist { v: -row.linear, w: -row.angular_a }
    }
}

impl Joints {
    /// Factorise S for the rows of a step.
    pub fn prepare(&mut self, masses: &Masses) {
        (self.of, self.is_old) = (None, false);
        if self.rows.is_empty() {
            return;
        }
        self.analyse_what_is_new(masses);
        self.factorise_with_bounds(masses);
    }

    /// Factorise the rows, whose pattern is known, with motors and limits as they are.
    fn factorise_with_bounds(&mut self, masses: &Masses) {
        if self.motors.soften_lagging(&mut self.rows, masses) {
            // A motor that presses against a limit aims at what is beyond.
            self.limits.soften_all(&mut self.rows, masses);
            self.factorise(masses);
            let mut motors = std::mem::take(&mut self.motors);
            motors.aim(|motor, scratch| self.response_along(masses, motor, scratch));
            self.motors = motors;
        }
        self.motors.soften(&mut self.rows, masses);
        self.limits.soften(&mut self.rows, masses);
        self.factorise(masses);
        self.motors.set_bias(&self.rows, &mut self.bias);
        self.limits.set_bias(&mut self.bias);
    }

    /// Analyse the sparsity pattern of the rows, where it is not known.
    fn analyse_what_is_new(&mut self, masses: &Masses) {
        let known = &self.pattern.bodies;
        if known.len() != self.rows.len() || self.rows.iter().zip(known).any(|(r, p)| r.bodies != *p) {
            self.analyse(masses);
            (self.is_new, self.is_factorised) = (true, false);
        }
    }

    /// Find the compliance of the rows. Returns the greatest diagonal of S without it, 1/kg or 1/(kg m²).
    fn find_softness(&mut self, masses: &Masses) -> f64 {
        let Joints { rows, softness, part, limits, .. } = self;
        let least = |row: &Row, of_diagonal: f64| {
            let diagonal = masses.response(row).max(f64::MIN_POSITIVE);
            ((of_diagonal / *part * diagonal).max(row.softness), diagonal)
        };
        softness.clear();
        let mut largest = f64::MIN_POSITIVE;
        for row in &*rows {
            let (soft, diagonal) = least(row, REGULARIZATION);
            largest = diagonal.max(largest);
            softness.push(soft);
        }
        for row in limits.iter().map(|limit| limit.row as usize) {
            softness[row] = least(&rows[row], REGULARIZATION_OF_LIMITS).0;
        }
        largest
    }

    fn factorise(&mut self, masses: &Masses) {
        if std::mem::take(&mut self.is_factorised) {
            return;
        }
        let largest = self.find_softness(masses);
        let Joints { rows, pattern, factor, softness, .. } = self;
        let on_diagonal = factor.diagonal();
        softness.iter().zip(&pattern.place).for_each(|(softness, place)| on_diagonal[*place as usize] = *softness);
        factor.factorise(1e-14 * largest, |front, element, first| pattern.fill(front, element, first, rows, masses));
    }

    /// The rate that a unit impulse of a motor that moves freely gives its joint, with all other rows, 1/kg or 1/(kg m²).
    fn response_along(&mut self, masses: &Masses, motor: &Motor, scratch: &mut Response) -> f64 {
        let row = motor.row as usize;
        scratch.twist.resize(masses.inv_mass.len(), Twist::default());
        self.rows.iter().flat_map(|row| row.bodies).for_each(|b| scratch.twist[b as usize] = Twist::default());
        masses.apply_row_impulse(&mut scratch.twist, &self.rows[row], 1.0);
        self.reset(scratch);
        self.solve_at_rest(masses, scratch);
        self.rows[row].speed_in(&scratch.twist).max(0.0)
    }

    /// Number of motors with a maximum effort, and of limits.
    pub fn n_bounds(&self) -> usize {
        self.motors.len() + self.limits.len()
    }

    /// Keep the bias of the rows, from which each round begins.
    pub fn begin_rounds(&mut self) {
        self.rounds = Rounds::default();
        self.linear_bias.clone_from(&self.bias);
    }

    /// End a round that has come to a response, in which errors of rates of up to `error`, m/s or rad/s, are not seen: bounds on the wrong side change.
    /// Returns whether there is another round, and the greatest excess of a bound, m/s or rad/s. The response may be lost where there is.
    pub fn end_round(&mut self, masses: &Masses, response: &mut Response, error: f64) -> (bool, f64) {
        let wrong = self.wrong_bounds(masses, response, error);
        let next = self.rounds.next(&wrong, [self.n_bounds(), self.limits.len()]);
        match next {
            Next::End => {}
            Next::Turn(n) => self.pivot(&wrong[..n]),
            Next::Settle { is_first } => self.settle_limits(masses, response, is_first),
        }
        (next != Next::End, wrong.iter().fold(0.0, |most, wrong| wrong.excess.max(most)))
    }

    /// Append a row of which the step leaves `kept` of Ψ, m or rad, with its bias, m/s or rad/s.
    pub fn push(&mut self, row: Row, kept: f64, bias: f64) {
        self.rows.push(row);
        self.kept.push(kept);
        self.bias.push(bias);
    }

    /// The motors that are on the wrong side of their maximum effort in a response, then the limits that would pull or be passed; errors of rates of
    /// up to `error`, m/s or rad/s, are not seen.
    fn wrong_bounds(&self, masses: &Masses, response: &Response, error: f64) -> Vec<Wrong> {
        let mut wrong = self.motors.wrong(&self.rows, masses, response, error);
        let limits = self.limits.wrong(&self.rows, masses, response, error);
        let n = self.motors.len();
        wrong.extend(limits.into_iter().map(|wrong| Wrong { index: n + wrong.index, ..wrong }));
        wrong
    }

    /// Put bounds on their other sides, for another round.
    fn pivot(&mut self, wrong: &[Wrong]) {
        let n = self.motors.len();
        for wrong in wrong {
            match wrong.index.checked_sub(n) {
                None => self.motors.set(wrong),
                Some(index) => self.limits.set(&Wrong { index, ..*wrong }),
            }
        }
        self.bias.clone_from(&self.linear_bias);
    }

    /// Whether the structure of the factor is another than when this was last asked.
    pub fn take_is_new(&mut self) -> bool {
        std::mem::take(&mut self.is_new)
    }

    fn analyse(&mut self, masses: &Masses) {
        let factor = self.pattern.analyse(&self.rows, |body| masses.inv_mass[body as usize] > 0.0);
        (self.factor, self.of) = (factor, None);
        self.is_held.clear();
        self.is_held.resize(masses.inv_mass.len(), false);
        self.pattern.held.iter().for_each(|body| self.is_held[*body as usize] = true);
    }

    /// Numbers of the factor, and multiplications that it takes.
    pub fn size(&self) -> (usize, u64) {
        (self.factor.n_numbers(), self.factor.work())
    }

    /// Factorise S for single precision: rows that follow from others give way.
    pub fn reduce(&self, masses: &Masses, reduced: &mut Reduced) {
        let Joints { rows, pattern, factor, softness, .. } = self;
        reduced.factor.clone_from(factor);
        reduced.softness.clone_from(softness);
        reduced.weakest = f64::INFINITY;
        if rows.is_empty() {
            return;
        }
        let pivots = factor.pivots();
        let mut largest = f64::MIN_POSITIVE;
        for (k, (row, place)) in rows.iter().zip(&pattern.place).enumerate() {
            let response = masses.response(row).max(f64::MIN_POSITIVE);
            let share = pivots[*place as usize] / (response + softness[k]);
            largest = response.max(largest);
            if share < DEPENDENT {
                reduced.softness[k] = response / DEPENDENT.powi(2);
            } else {
                reduced.weakest = share.min(reduced.weakest);
            }
            reduced.factor.diagonal()[*place as usize] = reduced.softness[k];
        }
        if reduced.softness != *softness {
            let fill = |front: &mut Front, element, first: &[u32]| pattern.fill(front, element, first, rows, masses);
            reduced.factor.factorise(1e-14 * largest, fill);
        }
    }

    /// The rows, and the place of each among those of the factor.
    pub fn placed(&self) -> impl Iterator<Item = (&Row, u32)> {
        self.rows.iter().zip(self.pattern.place.iter().copied())
    }

    /// Whether a joint acts on a moving body.
    #[inline]
    pub fn hold(&self, body: u32) -> bool {
        !self.rows.is_empty() && self.is_held[body as usize]
    }

    /// The bodies with rows that move, ascending.
    pub fn held(&self) -> &[u32] {
        &self.pattern.held
    }

    /// The mechanism of each of these bodies: those that rows connect, below the number of bodies.
    pub fn mechanisms(&self) -> &[u32] {
        &self.pattern.mechanism
    }

    /// Discard the sparsity pattern: other bodies move.
    pub fn invalidate(&mut self) {
        self.pattern.bodies.clear();
    }

    /// Discard all that the analysis has found.
    pub fn forget(&mut self) {
        self.pattern = Pattern::default();
    }

    /// Reset the multipliers of a response to zero, for velocities without joints.
    pub fn reset(&self, response: &mut Response) {
        response.lambda.clear();
        response.lambda.resize(self.rows.len(), 0.0);
    }

    /// Solve the joints: update the multipliers λ and the velocities of a response whose velocities include the effect of its λ.
    pub fn solve(&mut self, masses: &Masses, response: &mut Response) {
        self.solve_with(masses, response, 1.0);
    }

    /// [`Joints::solve`] for rows that are where they shall be and stay there.
    pub fn solve_at_rest(&mut self, masses: &Masses, response: &mut Response) {
        self.solve_with(masses, response, 0.0);
    }

    fn solve_with(&mut self, masses: &Masses, response: &mut Response, bias: f64) {
        if self.rows.is_empty() {
            return;
        }
        let rhs = self.factor.rows();
        if !self.pattern.hubs.is_empty() {
            rhs.fill(0.0);
        }
        for (k, row) in self.rows.iter().enumerate() {
            let speed = row.speed_in(&response.twist);
            rhs[self.pattern.place[k] as usize] =
                -(speed + bias * self.bias[k] + self.softness[k] * response.lambda[k]);
        }
        if self.is_old {
            self.n_solves += 1;
            if self.n_solves == 1 {
                self.first_left = rhs.iter().fold(0.0, |most: f64, left| most.max(left.abs()));
            }
        }
        self.factor.solve();
        let more = self.factor.rows();
        for ((row, place), lambda) in self.rows.iter().zip(&self.pattern.place).zip(&mut response.lambda) {
            let more = more[*place as usize];
            *lambda += more;
            masses.apply_row_impulse(&mut response.twist, row, more);
        }
    }

    /// The greatest |dΨ/dt + Cλ| of a response, for rows that are where they shall be, m/s or rad/s.
    pub fn residual_at_rest(&self, response: &Response) -> f64 {
        self.residual_with(response, 0.0)
    }

    /// The greatest rate that a response leaves of the rows, with a share of their bias, m/s or rad/s.
    fn residual_with(&self, response: &Response, bias: f64) -> f64 {
        let left = |(k, row): (usize, &Row)| {
            row.speed_in(&response.twist) + bias * self.bias[k] + self.softness[k] * response.lambda[k]
        };
        self.rows.iter().enumerate().map(left).fold(0.0, |max, r| r.abs().max(max))
    }

    /// The rate by which a row gives way, Cλ, m/s or rad/s.
    #[inline]
    pub fn given(&self, row: usize, response: &Response) -> f64 {
        self.softness[row] * response.lambda[row]
    }

    /// λᵀCλ of a difference of multipliers.
    pub fn compliance(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).zip(&self.softness).map(|((p, q), c)| c * (p - q) * (p - q)).sum()
    }
}

impl Pattern {
    /// Analyse the pattern of some rows; `moves` tells which bodies move. Returns the factorisation that it asks for.
    fn analyse(&mut self, rows: &[Row], moves: impl Fn(u32) -> bool) -> Factor {
        self.bodies.clear();
        self.bodies.extend(rows.iter().map(|r| r.bodies));
        let key = |row: &Row| {
            let [a, b] = row.bodies.map(|body| if moves(body) { body } else { NONE });
            [a.min(b), a.max(b)]
        };
        let mut by_group: Vec<([u32; 2], u32)> = rows.iter().enumerate().map(|(k, r)| (key(r), k as u32)).collect();
        by_group.sort_unstable();
        self.row.clear();
        self.row.extend(by_group.iter().map(|(_, k)| *k));
        let mut groups: Vec<[u32; 2]> = vec![];
        self.row_start.clear();
        for (k, (key, _)) in by_group.iter().enumerate() {
            if groups.last() != Some(key) {
                groups.push(*key);
                self.row_start.push(k as u32);
            }
        }
        self.row_start.push(rows.len() as u32);
        if self.groups != groups {
            self.groups = groups;
            self.connect();
        }
        let mut size: Vec<u32> = self.row_start.windows(2).map(|w| w[1] - w[0]).collect();
        size.extend(self.hubs.iter().map(|_| 6));
        let factor = Factor::new(Structure::analyse(&size, self.groups.len(), &self.order, &mut self.groups_of));
        self.place.clear();
        self.place.resize(rows.len(), 0);
        for (group, first) in self.row_start.windows(2).zip(factor.first()) {
            for (k, row) in self.row[group[0] as usize..group[1] as usize].iter().enumerate() {
                self.place[*row as usize] = first + k as u32;
            }
        }
        factor
    }

    /// Choose the hubs, list the parts of S, and order the groups.
    fn connect(&mut self) {
        let moving = |key: &[u32; 2]| key.iter().copied().filter(|b| *b != NONE).collect::<Vec<u32>>();
        self.held = self.groups.iter().flat_map(moving).collect();
        self.held.sort_unstable();
        let runs = self.held.chunk_by(|a, b| a == b).map(|run| (std::cmp::Reverse(run.len()), run[0]));
        let mut hubs: Vec<_> = runs.filter(|(n, _)| n.0 > HUB).collect();
        hubs.sort_unstable();
        self.hubs = hubs.iter().take(MOST_HUBS).map(|(_, body)| *body).collect();
        self.held.dedup();
        self.mechanism = mechanisms(&self.held, &self.groups);
        let n = self.groups.len() as u32;
        let hub = |body: u32| self.hubs.iter().position(|h| *h == body).map(|h| n + h as u32);
        let mut of_body: std::collections::BTreeMap<u32, Vec<u32>> = Default::default();
        (self.parts, self.groups_of) = self.hubs.iter().map(|body| (*body, hub(*body).into_iter().collect())).unzip();
        let mut ends = vec![[None; 2]; self.groups.len()];
        for (g, key) in self.groups.iter().enumerate() {
            for (end, body) in ends[g].iter_mut().zip(moving(key)) {
                if let Some(hub) = hub(body) {
                    self.parts.push(body);
                    self.groups_of.push(vec![g as u32, hub]);
                } else {
                    of_body.entry(body).or_default().push(g as u32);
                    *end = self.held.binary_search(&body).ok().map(|b| b as u32);
                }
            }
        }
        self.parts.extend(of_body.keys());
        self.groups_of.extend(of_body.into_values());
        // Rows between hubs alone have pivots once a hub has been eliminated.
        let between_hubs = |g: &u32| ends.get(*g as usize) == Some(&[None; 2]);
        let order = sparse::order(self.held.len(), &ends);
        let (last, first): (Vec<u32>, Vec<u32>) = order.into_iter().partition(between_hubs);
        self.order = [first, (n..n + self.hubs.len() as u32).collect(), last].concat();
    }

    fn rows_of(&self, group: u32) -> &[u32] {
        let g = group as usize;
        &self.row[self.row_start[g] as usize..self.row_start[g + 1] as usize]
    }

    /// Add a part of S to a front: what the rows of a body have by its mass, or the velocities of a hub. `first` are the first rows
    /// there of the part's groups.
    fn fill(&self, front: &mut Front, part: usize, first: &[u32], rows: &[Row], masses: &Masses) {
        let (body, groups) = (self.parts[part], &self.groups_of[part]);
        let b = body as usize;
        if let Some(hub) = groups.iter().position(|g| *g as usize >= self.groups.len()) {
            let first_of_hub = first[hub] as usize;
            match groups.len() {
                1 => add_mass(front, first_of_hub, 1.0 / masses.inv_mass[b], masses.inertia(b)),
                _ => {
                    let jacobian = |row: &u32| on_body(&rows[*row as usize], body);
                    add_jacobians(
                        front,
                        first_of_hub,
                        first[1 - hub] as usize,
                        self.rows_of(groups[1 - hub]).iter().map(jacobian),
                    );
                }
            }
            return;
        }
        let (inv_mass, inv_inertia) = (masses.inv_mass[b], masses.inv_inertia(b));
        let n = groups.iter().map(|g| self.rows_of(*g).len()).sum();
        let mut own: Vec<(usize, Twist)> = Vec::with_capacity(n);
        for (g, first) in groups.iter().zip(first) {
            for (k, row) in self.rows_of(*g).iter().enumerate() {
                let place = *first as usize + k;
                let jacobian = on_body(&rows[*row as usize], body);
                let response = Twist { v: jacobian.v * inv_mass, w: inv_inertia * jacobian.w };
                own.push((place, jacobian));
                let mut row = front.row(place);
                for (other, jacobian) in &own {
                    row.add(*other, response.v.dot(jacobian.v) + response.w.dot(jacobian.w));
                }
            }
        }
    }
}

/// A number for each of `bodies`, which are ascending, that those have in common which `groups` connect: the index of the first of them.
fn mechanisms(bodies: &[u32], groups: &[[u32; 2]]) -> Vec<u32> {
    let place = |body: u32| bodies.binary_search(&body).expect("a body with rows") as u32;
    let mut sets = DisjointSets::new(bodies.len());
    groups.iter().filter(|group| !group.contains(&NONE)).for_each(|group| sets.join(group.map(place)));
    (0..bodies.len() as u32).map(|k| sets.of(k)).collect()
}

/// Subtract a hub's mass matrix from the rows of its velocities.
fn add_mass(front: &mut Front, first: usize, mass: f64, inertia: DMat3) {
    for i in 0..3 {
        front.row(first + i).add(first + i, -mass);
        (0..=i).for_each(|j| front.row(first + 3 + i).add(first + 3 + j, -inertia.col(j)[i]));
    }
}

/// Add the Jacobians of rows on a hub: of its velocities, whose rows begin at `hub`, and of the rows from `first` on.
fn add_jacobians(front: &mut Front, hub: usize, first: usize, jacobians: impl Iterator<Item = Twist>) {
    for (k, Twist { v, w }) in jacobians.enumerate() {
        for (c, x) in v.to_array().into_iter().chain(w.to_array()).enumerate() {
            let (i, j) = (hub + c, first + k);
            front.row(i.max(j)).add(i.min(j), x);
        }
    }
}
