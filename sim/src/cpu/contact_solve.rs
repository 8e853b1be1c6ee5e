//! Solve the step's cone complementarity problem for the contact impulses γ.
//! in   contacts                    [n_contacts]  all columns; gamma is the starting point
//!      linear, angular             [n_bodies]    velocities without contact impulses, world
//! out  gamma                       [n_contacts]  N s
//!      linear, angular             [n_bodies]    velocities with them
//!
//! Per contact, with its frame A_p = [n u w] and b = (Φ/h, 0, 0):  minimise ½ γᵀNγ + rᵀγ over γ in the cone |γ_t| ≤ μ γ_n,
//! with N = Dᵀ M⁻¹ D and r = b + Dᵀ v_free. N is never formed: `M⁻¹ D γ` is summed body by body over each body's contacts
//! in a fixed order, `Dᵀ v` is read contact by contact.
//!
//! The metric: contact i's steps are scaled by η_i = 3/trace(D_iᵀ M⁻¹ D_i), one number a contact, so that its cone is kept.
//! Sources: Negrut et al. 2012, Algorithm 1 (Jacobi); Mazhar et al. 2015 (accelerated projected gradient descent, APGD).

use super::{PIECE, fill_rows};
use crate::state::{tangents, world_inv_inertia};
use crate::{Contacts, FrictionLaw, Model, State};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// The iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The paper's Algorithm 1.
    Jacobi,
    /// Accelerated projected gradient descent with adaptive restart.
    Apgd,
}

/// How contacts are solved; also the `solver` section of a model file.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// `apgd` or `jacobi`.
    pub method: Method,
    /// The law of friction: `relaxed` (the paper's convex form) or `exact`.
    pub friction: FrictionLaw,
    /// The most iterations a step.
    pub iterations: u32,
    /// Stop when the residual (as in `report.csv`) is below this, m/s; 0 does all iterations.
    pub tolerance: f64,
    /// Jacobi's relaxation ω.
    pub omega: f64,
    /// Jacobi's smoothing λ.
    pub lambda: f64,
    /// Whether impulses of the last step are the starting point.
    pub warm_start: bool,
    /// Greatest speed at which an overlap is pushed apart, m/s.
    pub recovery_speed: f64,
    /// Contacts are made at gaps up to this, and farther for fast bodies, m; a fiftieth of the least moving shape if not given.
    pub envelope: Option<f64>,
}

impl Default for SolverSettings {
    fn default() -> SolverSettings {
        SolverSettings {
            method: Method::Apgd,
            friction: FrictionLaw::Relaxed,
            iterations: 50,
            tolerance: 1e-7,
            omega: 0.3,
            lambda: 1.0,
            warm_start: true,
            recovery_speed: 1.0,
            envelope: None,
        }
    }
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Iterations done.
    pub iterations: u32,
    /// `‖(γ − Π(γ − g (Nγ + r))) / g‖₂ / n_contacts` with g = 10⁻³ η: the velocity, m/s, by which contacts still miss their cones.
    pub residual: f64,
}

/// The solver's own columns, kept from step to step.
#[derive(Default)]
pub struct Workspace {
    /// r without the bodies' part: (Φ/h, 0, 0), or with μ|v_t| added for exact friction (n_contacts).
    b: Vec<DVec3>,
    /// η (n_contacts).
    eta: Vec<f64>,
    /// γ as an impulse of the world frame (n_contacts).
    impulse: Vec<DVec3>,
    /// M⁻¹ D γ (n_bodies).
    change: Vec<[DVec3; 2]>,
    /// R J̄⁻¹ Rᵀ (n_bodies).
    inv_inertia: Vec<DMat3>,
    /// Dᵀ v_free + b (n_contacts).
    r: Vec<DVec3>,
    /// Points of the accelerated sequence, and N times them (n_contacts).
    y: Vec<DVec3>,
    n_y: Vec<DVec3>,
    next: Vec<DVec3>,
    n_next: Vec<DVec3>,
    n_gamma: Vec<DVec3>,
    best: Vec<DVec3>,
    /// The step length that was right for the last step's APGD.
    step_length: f64,
}

/// Project onto the cone |γ_t| ≤ μ γ_n.
#[inline]
pub fn project(g: DVec3, mu: f64) -> DVec3 {
    let tangential = (g.y * g.y + g.z * g.z).sqrt();
    if tangential <= mu * g.x {
        g
    } else if tangential * mu <= -g.x {
        DVec3::ZERO
    } else {
        let normal = (tangential * mu + g.x) / (mu * mu + 1.0);
        let scale = mu * normal / tangential;
        DVec3::new(normal, g.y * scale, g.z * scale)
    }
}

/// The stage.
pub fn run(
    model: &Model,
    state: &State,
    contacts: &mut Contacts,
    work: &mut Workspace,
    linear: &mut [DVec3],
    angular: &mut [DVec3],
) -> Outcome {
    work.prepare(model, state, contacts);
    let outcome = match model.solver.friction {
        FrictionLaw::Relaxed => work.solve(model, contacts, linear, angular, model.solver.iterations),
        FrictionLaw::Exact => work.solve_exact(model, contacts, linear, angular),
    };
    work.spread_to_bodies(model, contacts, &contacts.gamma);
    for (b, [dv, dw]) in work.change.iter().enumerate() {
        linear[b] += *dv;
        angular[b] += *dw;
    }
    outcome
}

impl Workspace {
    /// b, η and the bodies' reciprocal inertias of this step.
    fn prepare(&mut self, model: &Model, state: &State, contacts: &Contacts) {
        let n = contacts.len();
        for column in [&mut self.b, &mut self.impulse, &mut self.r, &mut self.y, &mut self.n_y, &mut self.next] {
            column.resize(n, DVec3::ZERO);
        }
        for column in [&mut self.n_next, &mut self.n_gamma, &mut self.best] {
            column.resize(n, DVec3::ZERO);
        }
        self.eta.resize(n, 0.0);
        self.inv_inertia.resize(model.n_bodies(), DMat3::ZERO);
        self.change.resize(model.n_bodies(), [DVec3::ZERO; 2]);
        fill_rows(&mut self.inv_inertia, |b| world_inv_inertia(state.orientation[b], model.inv_inertia[b]));
        fill_rows(&mut self.b, |i| {
            DVec3::new((contacts.gap[i] / model.step).max(-model.solver.recovery_speed), 0.0, 0.0)
        });
        let inv_inertia = &self.inv_inertia;
        fill_rows(&mut self.eta, |i| {
            let [a, b] = contacts.bodies[i].map(|b| b as usize);
            let (n, (u, w)) = (contacts.normal[i], tangents(contacts.normal[i]));
            let mut trace = 3.0 * (model.inv_mass[a] + model.inv_mass[b]);
            for (body, arm) in [(a, contacts.arm_a[i]), (b, contacts.arm_b[i])] {
                for d in [n, u, w] {
                    let c = arm.cross(d);
                    trace += c.dot(inv_inertia[body] * c);
                }
            }
            3.0 / trace
        });
    }

    /// Exact Coulomb friction: the gap's rate is fed with the slip, μ|v_t|, until it is the slip that comes out.
    fn solve_exact(&mut self, model: &Model, contacts: &mut Contacts, linear: &[DVec3], angular: &[DVec3]) -> Outcome {
        const ROUNDS: u32 = 20;
        let b0 = self.b.clone();
        let mut total = Outcome::default();
        let mut slip_before = f64::INFINITY;
        for _ in 0..ROUNDS {
            let budget = (model.solver.iterations / 4).max(1);
            let outcome = self.solve(model, contacts, linear, angular, budget);
            total.iterations += outcome.iterations;
            total.residual = outcome.residual;
            // n_gamma + r − b is the relative velocity that the solution leaves.
            let (mut change, mut slip_sum) = (0.0, 0.0);
            for i in 0..contacts.len() {
                let v = self.n_gamma[i] + self.r[i];
                let slip = contacts.friction[i] * (v.y * v.y + v.z * v.z).sqrt();
                let b = b0[i] + DVec3::new(slip, 0.0, 0.0);
                change += (b.x - self.b[i].x).abs();
                slip_sum += slip;
                self.b[i] = b;
            }
            if total.iterations >= model.solver.iterations || change <= 1e-9 * slip_sum.max(slip_before.min(1.0)) {
                break;
            }
            slip_before = slip_sum;
        }
        total
    }

    fn solve(
        &mut self,
        model: &Model,
        contacts: &mut Contacts,
        linear: &[DVec3],
        angular: &[DVec3],
        n: u32,
    ) -> Outcome {
        if contacts.is_empty() {
            return Outcome::default();
        }
        let mut r = std::mem::take(&mut self.r);
        fill_rows(&mut r, |i| self.b[i] + relative_velocity(contacts, i, |b| (linear[b], angular[b])));
        self.r = r;
        let mut gamma = std::mem::take(&mut contacts.gamma);
        gamma.iter_mut().zip(&contacts.friction).for_each(|(g, mu)| *g = project(*g, *mu));
        let outcome = match model.solver.method {
            Method::Jacobi => self.jacobi(model, contacts, &mut gamma, n),
            Method::Apgd => self.apgd(model, contacts, &mut gamma, n),
        };
        contacts.gamma = gamma;
        outcome
    }

    /// change = M⁻¹ D γ, body by body.
    fn spread_to_bodies(&mut self, model: &Model, contacts: &Contacts, gamma: &[DVec3]) {
        fill_rows(&mut self.impulse, |i| world_impulse(contacts, i, gamma[i]));
        let (impulse, inv_inertia) = (&self.impulse, &self.inv_inertia);
        fill_rows(&mut self.change, |body| {
            if model.inv_mass[body] == 0.0 {
                return [DVec3::ZERO; 2];
            }
            let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
            for incident in contacts.of_body(body) {
                let i = *incident as usize / 2;
                if incident & 1 == 1 {
                    linear += impulse[i];
                    angular += contacts.arm_b[i].cross(impulse[i]);
                } else {
                    linear -= impulse[i];
                    angular -= contacts.arm_a[i].cross(impulse[i]);
                }
            }
            [linear * model.inv_mass[body], inv_inertia[body] * angular]
        });
    }

    /// N γ = Dᵀ (M⁻¹ D γ), into `out`.
    fn apply(&mut self, model: &Model, contacts: &Contacts, gamma: &[DVec3], out: &mut [DVec3]) {
        self.spread_to_bodies(model, contacts, gamma);
        fill_rows(out, |i| relative_velocity(contacts, i, |b| (self.change[b][0], self.change[b][1])));
    }

    /// The paper's Algorithm 1: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ.
    fn jacobi(&mut self, model: &Model, contacts: &Contacts, gamma: &mut Vec<DVec3>, n: u32) -> Outcome {
        let settings = &model.solver;
        let mut outcome = Outcome::default();
        let mut n_gamma = std::mem::take(&mut self.n_gamma);
        let mut next = std::mem::take(&mut self.next);
        self.apply(model, contacts, gamma, &mut n_gamma);
        for iteration in 1..=n {
            let (eta, r) = (&self.eta, &self.r);
            fill_rows(&mut next, |i| {
                let stepped = gamma[i] - (n_gamma[i] + r[i]) * (settings.omega * eta[i]);
                project(stepped, contacts.friction[i]) * settings.lambda + gamma[i] * (1.0 - settings.lambda)
            });
            std::mem::swap(gamma, &mut next);
            self.apply(model, contacts, gamma, &mut n_gamma);
            outcome = Outcome { iterations: iteration, residual: self.residual(contacts, gamma, &n_gamma) };
            if outcome.residual <= settings.tolerance {
                break;
            }
        }
        self.n_gamma = n_gamma;
        self.next = next;
        outcome
    }

    fn residual(&self, contacts: &Contacts, gamma: &[DVec3], n_gamma: &[DVec3]) -> f64 {
        let [sum] =
            sum_rows(contacts.len(), |i| [miss(gamma[i], n_gamma[i] + self.r[i], self.eta[i], contacts.friction[i])]);
        sum.sqrt() / contacts.len() as f64
    }

    /// APGD. One product with N an iteration: N y is the same combination of N γ's as y is of γ's.
    fn apgd(&mut self, model: &Model, contacts: &Contacts, gamma: &mut Vec<DVec3>, n: u32) -> Outcome {
        let mut y = std::mem::take(&mut self.y);
        let mut n_y = std::mem::take(&mut self.n_y);
        let mut next = std::mem::take(&mut self.next);
        let mut n_next = std::mem::take(&mut self.n_next);
        let mut n_gamma = std::mem::take(&mut self.n_gamma);
        self.apply(model, contacts, gamma, &mut n_gamma);
        y.copy_from_slice(gamma);
        n_y.copy_from_slice(&n_gamma);
        self.best.copy_from_slice(gamma);
        let mut best = Outcome { iterations: 0, residual: self.residual(contacts, gamma, &n_gamma) };
        let mut best_is_current = true;
        let mut theta: f64 = 1.0;
        let mut step = if self.step_length > 0.0 { self.step_length } else { 1.0 };
        let mut done = 0;
        while done < n && best.residual > model.solver.tolerance {
            let mut sums;
            loop {
                {
                    let (eta, r) = (&self.eta, &self.r);
                    fill_rows(&mut next, |i| project(y[i] - (n_y[i] + r[i]) * (step * eta[i]), contacts.friction[i]));
                }
                self.apply(model, contacts, &next, &mut n_next);
                done += 1;
                let (eta, r) = (&self.eta, &self.r);
                sums = sum_rows(contacts.len(), |i| {
                    let d = next[i] - y[i];
                    let gradient = n_next[i] + r[i];
                    [
                        d.dot(n_next[i] - n_y[i]),
                        d.length_squared() / eta[i],
                        (n_y[i] + r[i]).dot(next[i] - gamma[i]),
                        miss(next[i], gradient, eta[i], contacts.friction[i]),
                    ]
                });
                // The step is short enough if ½ dᵀNd ≤ |d|²/(2 t) in the metric of η.
                if sums[0] * step <= sums[1] * (1.0 + 1e-9) || done >= n {
                    break;
                }
                step = (0.95 * sums[1] / sums[0]).min(0.95 * step);
            }
            let residual = sums[3].sqrt() / contacts.len() as f64;
            let next_theta = 0.5 * (theta * (theta * theta + 4.0).sqrt() - theta * theta);
            let uphill = sums[2] > 0.0;
            let beta = if uphill { 0.0 } else { theta * (1.0 - theta) / (theta * theta + next_theta) };
            theta = if uphill { 1.0 } else { next_theta };
            y.copy_from_slice(&next);
            n_y.copy_from_slice(&n_next);
            if beta != 0.0 {
                fill_pair(&mut y, &mut n_y, |i| {
                    (next[i] + (next[i] - gamma[i]) * beta, n_next[i] + (n_next[i] - n_gamma[i]) * beta)
                });
            }
            std::mem::swap(gamma, &mut next);
            std::mem::swap(&mut n_gamma, &mut n_next);
            if residual < best.residual {
                best = Outcome { iterations: done, residual };
                best_is_current = true;
            } else if best_is_current {
                // What was swapped out is the best so far.
                self.best.copy_from_slice(&next);
                best_is_current = false;
            }
            self.step_length = step;
            step *= 1.1;
        }
        if !best_is_current {
            gamma.copy_from_slice(&self.best);
            self.apply(model, contacts, gamma, &mut n_gamma);
        }
        (self.y, self.n_y, self.next, self.n_next, self.n_gamma) = (y, n_y, next, n_next, n_gamma);
        Outcome { iterations: done, residual: best.residual }
    }
}

/// An impulse of the contact frame as one of the world.
#[inline]
fn world_impulse(contacts: &Contacts, i: usize, gamma: DVec3) -> DVec3 {
    let n = contacts.normal[i];
    let (u, w) = tangents(n);
    n * gamma.x + u * gamma.y + w * gamma.z
}

/// D_iᵀ v: the velocity of B's contact point against A's, in the contact frame.
#[inline]
fn relative_velocity(contacts: &Contacts, i: usize, of: impl Fn(usize) -> (DVec3, DVec3)) -> DVec3 {
    let [a, b] = contacts.bodies[i];
    let ((va, wa), (vb, wb)) = (of(a as usize), of(b as usize));
    let v = vb + wb.cross(contacts.arm_b[i]) - va - wa.cross(contacts.arm_a[i]);
    let n = contacts.normal[i];
    let (u, w) = tangents(n);
    DVec3::new(v.dot(n), v.dot(u), v.dot(w))
}

/// The square of a contact's part in the residual.
#[inline]
fn miss(gamma: DVec3, gradient: DVec3, eta: f64, mu: f64) -> f64 {
    let g = 1e-3 * eta;
    ((gamma - project(gamma - gradient * g, mu)) / g).length_squared()
}

/// Sum `f(i)` over the rows, piece by piece in order: the same bits for any number of threads.
fn sum_rows<const K: usize>(n: usize, f: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let piece = |p: usize| {
        let mut sum = [0.0; K];
        for i in p * PIECE..((p + 1) * PIECE).min(n) {
            let row = f(i);
            for k in 0..K {
                sum[k] += row[k];
            }
        }
        sum
    };
    let n_pieces = n.div_ceil(PIECE);
    let add = |mut a: [f64; K], b: [f64; K]| {
        for k in 0..K {
            a[k] += b[k];
        }
        a
    };
    if n_pieces <= 2 {
        return (0..n_pieces).map(piece).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = (0..n_pieces).into_par_iter().map(piece).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Fill two columns at once.
fn fill_pair(a: &mut [DVec3], b: &mut [DVec3], f: impl Fn(usize) -> (DVec3, DVec3) + Sync) {
    a.par_chunks_mut(PIECE).zip(b.par_chunks_mut(PIECE)).enumerate().for_each(|(piece, (a, b))| {
        for (i, (a, b)) in a.iter_mut().zip(b).enumerate() {
            (*a, *b) = f(piece * PIECE + i);
        }
    });
}
