//! Solve the step's cone complementarity problem: contact impulses, limits and joints at once.
//! in   contacts     [n_contacts]  all columns; `impulse` and `twist` are the starting point
//!      joint rows   [n_rows]      from `joint_write`
//!      free         [n_bodies]    velocities without contacts and joints, world
//! out  impulse      [n_contacts]  N s, world
//!      twist        [n_contacts]  N m s, world, where materials have rolling or spinning friction
//!      velocity     [n_bodies]    with all of them; and the joints' multipliers
//!
//! Per contact, with its normal n and b = (Φ/h) n: minimise ½ γᵀNγ + rᵀγ over γ in the cone |γ_t| ≤ μ γ_n, with
//! N = Dᵀ M̃⁻¹ D and r = b + Dᵀ v_free. The metric: contact i's steps are scaled by η_i = 3/trace(D_iᵀ M⁻¹ D_i), one number a
//! contact, so that its cone is kept. The methods are in [`crate::solve`].

use super::fill_rows;
use super::joint_write::JointErrors;
use crate::joint::Row;
use crate::solve::bodies::{BodyOperator, Falling, Recovery};
use crate::solve::joints::Joints;
use crate::solve::{self, Image, Outcome, Twist};
use crate::state::{Arms, is_isotropic, world_inv_inertia};
use crate::watch::residual_bound;
use crate::{Contacts, FrictionLaw, Method, Model, State};
use glam::{DMat3, DVec3};

/// Masses and moments of inertia in the world frame.
#[derive(Default)]
pub struct Masses {
    /// Reciprocal masses, 1/kg (n_bodies).
    pub inv_mass: Vec<f64>,
    /// Whether bodies have begun to move since the last step.
    pub changed: bool,
    /// Reciprocal moment of bodies that turn alike about all axes; NaN for the others (n_bodies).
    pub round: Vec<f64>,
    /// R J̄⁻¹ Rᵀ of the others, and its inverse, at `slot` (n_bodies; none if all are round).
    slot: Vec<u32>,
    tensor: Vec<[DMat3; 2]>,
}

impl Masses {
    /// Look which bodies move; whether that has changed since the last step.
    pub fn look(&mut self, model: &Model) -> bool {
        self.changed = self.inv_mass != model.inv_mass;
        if self.changed {
            self.inv_mass.clone_from(&model.inv_mass);
            self.round = model.inv_inertia.iter().map(|i| if is_isotropic(*i) { i.x } else { f64::NAN }).collect();
            let mut n = 0;
            self.slot = self.round.iter().map(|r| if r.is_nan() { (n, n += 1).0 } else { u32::MAX }).collect();
            if n == 0 {
                self.slot = vec![];
            }
            self.tensor = vec![[DMat3::ZERO; 2]; n as usize];
        }
        self.changed
    }

    /// Turn the moments of inertia to where the bodies are.
    pub fn turn_to(&mut self, model: &Model, state: &State) {
        for (b, slot) in self.slot.iter().enumerate().filter(|(_, s)| **s != u32::MAX) {
            let inverse = world_inv_inertia(state.orientation[b], model.inv_inertia[b]);
            self.tensor[*slot as usize] =
                [inverse, world_inv_inertia(state.orientation[b], model.inv_inertia[b].recip())];
        }
    }

    /// Reciprocal inertia times a vector.
    #[inline(always)]
    pub fn turn(&self, body: usize, angular: DVec3) -> DVec3 {
        let round = self.round[body];
        if round.is_nan() { self.tensor[self.slot[body] as usize][0] * angular } else { angular * round }
    }

    /// Twice the kinetic energy of a motion, J; 0 for a body that is held in place.
    #[inline(always)]
    pub fn energy(&self, body: usize, t: &Twist) -> f64 {
        let (inv_mass, round) = (self.inv_mass[body], self.round[body]);
        if inv_mass == 0.0 {
            return 0.0;
        }
        let turning = if round.is_nan() {
            t.w.dot(self.tensor[self.slot[body] as usize][1] * t.w)
        } else {
            t.w.length_squared() / round
        };
        t.v.length_squared() / inv_mass + turning
    }

    /// Give a body an impulse, N s, and an angular impulse, N m s.
    #[inline]
    pub fn push(&self, motion: &mut [Twist], body: u32, linear: DVec3, angular: DVec3) {
        let b = body as usize;
        motion[b].v += linear * self.inv_mass[b];
        motion[b].w += self.turn(b, angular);
    }

    /// Give the two bodies of a row an impulse along it.
    pub fn push_row(&self, motion: &mut [Twist], row: &Row, impulse: f64) {
        self.push(motion, row.bodies[0], row.linear * -impulse, row.angular_a * -impulse);
        self.push(motion, row.bodies[1], row.linear * impulse, row.angular_b * impulse);
    }

    /// The change of a row's speed by a unit impulse along it, 1/kg.
    pub fn response(&self, row: &Row) -> f64 {
        let own = |b: u32, angular: DVec3| {
            let b = b as usize;
            row.linear.length_squared() * self.inv_mass[b] + self.turn(b, angular).dot(angular)
        };
        own(row.bodies[0], row.angular_a) + own(row.bodies[1], row.angular_b)
    }

    /// Reciprocal inertia.
    pub fn inertia(&self, body: usize) -> DMat3 {
        let round = self.round[body];
        if round.is_nan() {
            self.tensor[self.slot[body] as usize][0]
        } else {
            DMat3::from_diagonal(DVec3::splat(round))
        }
    }
}

/// The stage's own columns, kept from step to step.
#[derive(Default)]
pub struct Workspace {
    /// Masses of the step.
    pub masses: Masses,
    /// Joint rows of the step.
    pub joints: Joints,
    /// The rows of each joint; none while it does not hold (n_joints).
    pub joint_rows: Vec<std::ops::Range<usize>>,
    /// Limits of joints that may be met in the step.
    pub limits: Vec<Row>,
    /// Velocities without contacts and joints (n_bodies).
    pub free: Vec<Twist>,
    /// Velocities with them, and the joints' multipliers.
    pub image: Image,
    /// The bodies of the contact that misses most, where the residual is above [`residual_bound`].
    pub worst: Option<[u32; 2]>,
    /// Errors of the joints, from `joint_write`.
    pub joint_errors: JointErrors,
    /// h |F·v| of springs, summed, J, from `joint_write`.
    pub spring_swing: f64,
    gamma: Vec<DVec3>,
    offset: Vec<f64>,
    offset_unfed: Vec<f64>,
    eta: Vec<f64>,
    /// The methods' own.
    pub methods: solve::Workspace,
}

/// The stage.
pub fn run(model: &Model, state: &State, contacts: &mut Contacts, work: &mut Workspace) -> Outcome {
    let n = contacts.len();
    let rolls = !contacts.twist.is_empty();
    let plain = model.laws.iter().all(|l| l.cohesion == 0.0);
    let balls = plain && !rolls && work.limits.is_empty() && matches!(contacts.arms, Arms::Along(_));
    let sweeps_balls = balls && model.solver.method == Method::GaussSeidel && n > 0;
    work.prepare(model, state, contacts, sweeps_balls);
    let mut gamma = std::mem::take(&mut work.gamma);
    gamma.clear();
    if rolls || !work.limits.is_empty() {
        gamma.extend_from_slice(&contacts.impulse);
        gamma.extend_from_slice(&contacts.twist);
        gamma.resize(gamma.len() + work.limits.len(), DVec3::ZERO);
    } else {
        std::mem::swap(&mut gamma, &mut contacts.impulse);
    }
    let mut op = BodyOperator {
        contacts,
        laws: &model.laws,
        masses: &work.masses,
        free: &work.free,
        joints: &mut work.joints,
        limits: &work.limits,
        falling: Falling { model, state },
        offset: &mut work.offset,
        recovery: recovery_of(model),
        offset_unfed: &work.offset_unfed,
        eta: &work.eta,
        rolls,
        plain,
        envelope: model.envelope,
    };
    let outcome = if sweeps_balls {
        solve::balls::run(&mut op, &model.solver, &mut gamma, &mut work.image, &mut work.methods)
    } else {
        solve::solve(&mut op, &model.solver, &mut gamma, &mut work.image, &mut work.methods)
    };
    let has_missed = outcome.residual > residual_bound(model);
    work.worst = has_missed.then(|| op.bodies(solve::worst_block(&op, &gamma, &work.image)));
    if rolls || !work.limits.is_empty() {
        contacts.impulse.copy_from_slice(&gamma[..n]);
        if rolls {
            contacts.twist.copy_from_slice(&gamma[n..2 * n]);
        }
    } else {
        std::mem::swap(&mut gamma, &mut contacts.impulse);
    }
    work.gamma = gamma;
    outcome
}

fn recovery_of(model: &Model) -> Recovery {
    Recovery { step: model.step, speed: model.solver.recovery_speed }
}

/// Contacts that come together slower than this do not bounce, m/s.
const BOUNCE_LEAST: f64 = 1e-3;

impl Workspace {
    /// b and η of this step, and the joints' factorisation.
    /// Sweeps over balls make what they need of η themselves, and nothing is fed into their gaps.
    fn prepare(&mut self, model: &Model, state: &State, contacts: &Contacts, sweeps_balls: bool) {
        let (h, n) = (model.step, contacts.len());
        self.joints.prepare(&self.masses);
        let offset = &mut self.offset;
        let recovery = recovery_of(model);
        let bounces = model.laws.iter().any(|l| l.restitution > 0.0);
        let is_fed = model.solver.friction == FrictionLaw::Exact && !sweeps_balls;
        if bounces || is_fed || !self.limits.is_empty() {
            offset.resize(n + self.limits.len(), 0.0);
            fill_rows(&mut offset[..n], |i| {
                let opening = recovery.rate(contacts.gap[i]);
                if !bounces {
                    return opening;
                }
                let restitution = model.laws[contacts.law[i] as usize].restitution;
                let speed = contacts.velocity(state, i).dot(contacts.normal[i]);
                let least = BOUNCE_LEAST.max(2.0 * model.gravity.length() * h);
                let meets = speed < -least && contacts.gap[i] + h * speed <= 0.0;
                if restitution > 0.0 && meets { opening.min(restitution * speed) } else { opening }
            });
            for (k, row) in self.limits.iter().enumerate() {
                offset[n + k] = recovery.rate(row.psi);
            }
        } else {
            offset.clear();
        }
        if is_fed {
            self.offset_unfed.clone_from(offset);
        }
        if sweeps_balls {
            self.eta.clear();
            return;
        }
        let (masses, limits) = (&self.masses, &self.limits);
        let rolls = if contacts.twist.is_empty() { 0 } else { n };
        self.eta.resize(n + rolls + limits.len(), 0.0);
        fill_rows(&mut self.eta, |i| {
            if i < n {
                let [a, b] = contacts.bodies[i].map(|b| b as usize);
                let mut trace = 3.0 * (masses.inv_mass[a] + masses.inv_mass[b]);
                let [arm_a, arm_b] = contacts.arms(i);
                trace += turning_trace(masses, a, arm_a) + turning_trace(masses, b, arm_b);
                3.0 / trace
            } else if i < n + rolls {
                let [a, b] = contacts.bodies[i - n].map(|b| masses.inertia(b as usize));
                let m = a + b;
                3.0 / (m.x_axis.x + m.y_axis.y + m.z_axis.z)
            } else {
                1.0 / masses.response(&limits[i - n - rolls])
            }
        });
    }
}

/// trace([a]ᵀ J⁻¹ [a]) for an arm a.
#[inline]
fn turning_trace(masses: &Masses, body: usize, arm: DVec3) -> f64 {
    let round = masses.round[body];
    if !round.is_nan() {
        return 2.0 * round * arm.length_squared();
    }
    let inverse = masses.inertia(body);
    [DVec3::X, DVec3::Y, DVec3::Z].into_iter().map(|e| arm.cross(e).dot(inverse * arm.cross(e))).sum()
}
