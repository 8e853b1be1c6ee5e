//! Solve the step's cone complementarity problem: contact impulses and joints at once.
//! in     position          [n_bodies]     m
//! in     orientation       [n_bodies]
//! in     velocity          [n_bodies]     m/s
//! in     angular_velocity  [n_bodies]     rad/s
//! in     contact_start     [n_tiles + 2]
//! in     contact_bodies    [n_contacts]
//! in     contact_key       [n_contacts]   where not all contacts have Φ/h alone
//! in     contact_normal    [n_contacts]
//! in     contact_arms      [n_contacts]   m, or
//! in     contact_reach     [n_contacts]   m
//! in     contact_gap       [n_contacts]   m
//! in     contact_law       [n_contacts]
//! in     tensor            [n_tensors]
//! in     free              [n_bodies]     m/s and rad/s, world
//! in     joint_start       [n_joints + 1]
//! in     joint_row         [n_rows]
//! in     joint_kept        [n_rows]       m or rad
//! inout  joint_bias        [n_rows]       m/s: on the arcs of the step
//! inout  impulse           [n_contacts]   N s, world: the starting point, then the solution
//! inout  rolling_impulse   [n_contacts]   N m s, world
//! out    motion            [n_bodies]     m/s and rad/s, world
//! out    displacement      [n_bodies]     m/s and rad/s, world: the recovery of overlaps, over h; empty where nothing overlaps
//! out    joint_impulse     [n_rows]       N s, N m s
//!
//! The factor of the joints lasts for later steps where there are no contacts, and no limits that may be met ([`crate::joint_factor`]).
//!
//! Per contact, with its normal n and b = (Φ/h) n: minimise ½ γᵀNγ + rᵀγ over γ in the cone |γ_t| ≤ μ γ_n, with
//! N = Dᵀ M̃⁻¹ D and r = b + Dᵀ v_free. The metric: contact i's steps are scaled by η_i = 3/trace(D_iᵀ M⁻¹ D_i), one scalar per
//! contact, which preserves its cone. The methods are in [`super::solve`].

use super::arcs::{Arcs, Linear};
use super::impacts::bounces;
use super::masses::Masses;
use super::solve::bodies::{BodyOperator, Falling, Free, Offset, Recovery};
use super::solve::exact;
use super::solve::iterates::Iterates;
use super::solve::joints::Joints;
use super::solve::operator::Operator;
use super::solve::overlaps::{self, Displacement};
use super::solve::residual::{residual, worst_block};
use super::solve::response::Response;
use super::solve::support;
use super::solve::sweeps::{self, Sweeps};
use super::solve::{self};
use crate::contacts::Contacts;
use crate::joint_factor::JointFactor;
use crate::model::Model;
use crate::outcome::Outcome;
use crate::pace::Bend;
use crate::plan::{ContactMethod, Narrow, StepPlan};
use crate::rows::fill_rows;
use crate::settings::SolverSettings;
use crate::shape::ShapeKind;
use crate::state::State;
use crate::twist::Twist;
use crate::watch::residual_bound;
use glam::DVec3;

/// The columns that the stage reads and writes besides those of the contacts.
pub struct Columns<'a> {
    /// Masses and inertia tensors of the step.
    pub masses: &'a Masses,
    /// Velocities without contacts and joints (n_bodies, or empty: see the plan).
    pub free: &'a [Twist],
    /// Rows of the joints.
    pub joints: &'a mut Joints,
    /// Their factorisation for the steps to come.
    pub joint_factor: &'a mut JointFactor,
    /// First row of each joint, and of the springs (n_joints + 1).
    pub joint_start: &'a [u32],
    /// Velocities with contacts and joints, and the joints' multipliers.
    pub response: &'a mut Response,
    /// Recovery of overlaps.
    pub displacement: &'a mut Displacement,
}

impl Columns<'_> {
    /// The same columns for one more solve.
    fn again(&mut self) -> Columns<'_> {
        Columns {
            masses: self.masses,
            free: self.free,
            joints: self.joints,
            joint_factor: self.joint_factor,
            joint_start: self.joint_start,
            response: self.response,
            displacement: self.displacement,
        }
    }
}

/// The stage's own columns, which keep their memory from step to step.
#[derive(Default)]
pub struct Workspace {
    gamma: Vec<DVec3>,
    lifts: Vec<bool>,
    offset: Vec<f64>,
    offset_without_slip: Vec<f64>,
    last_slip: Vec<f64>,
    eta: Vec<f64>,
    iterates: Iterates,
    sweeps: Sweeps,
    arcs: Arcs,
}

/// The stage. Returns the solver's outcome, and the bodies of the block with the maximum residual where the step's is above
/// [`residual_bound`]. Where limits are met or left, and motors come to their maximum effort or from it to their rate, the step is solved again.
pub fn run(
    model: &Model,
    plan: &StepPlan,
    state: &State,
    contacts: &mut Contacts,
    mut columns: Columns,
    work: &mut Workspace,
) -> (Outcome, Option<[u32; 2]>) {
    columns.joints.begin_rounds();
    let mut iterations = 0;
    loop {
        work.arcs.bend = Bend::default();
        let (mut outcome, worst) = solve_once((model, plan, state), contacts, columns.again(), work);
        iterations += outcome.iterations;
        outcome.iterations = iterations;
        let (is_another, excess) = columns.joints.end_round(columns.masses, columns.response, 0.0);
        if !is_another {
            // Bounds without a side are a solve that has not converged.
            outcome.residual = outcome.residual.max(excess);
            return (outcome, worst);
        }
    }
}

/// Solve with motors and limits as they are.
fn solve_once(
    (model, plan, state): (&Model, &StepPlan, &State),
    contacts: &mut Contacts,
    Columns { masses, free, joints, joint_factor, joint_start, response, displacement }: Columns,
    work: &mut Workspace,
) -> (Outcome, Option<[u32; 2]>) {
    let n = contacts.len();
    let (method, settings) = match plan.start().filter(|_| begins(model, state, contacts)) {
        Some(start) => {
            support::fill(model, state, contacts);
            start
        }
        None => (plan.method_with(n), &model.solver),
    };
    if n == 0 {
        joints.prepare_from(masses, std::mem::take(joint_factor));
    } else {
        joints.prepare(masses);
        joint_factor.end();
    }
    let at = (model, state);
    // Without contacts the joints answer once.
    if n > 0 {
        let linear = Linear { start: joint_start, joints, masses };
        work.arcs.foresee(at, linear, free, response);
    }
    let has_offsets = work.fill_offsets(model, plan, state, contacts, joints, method);
    // Sweeps on packed contacts compute η themselves.
    match method {
        ContactMethod::Sweeps => work.eta.clear(),
        ContactMethod::Blocks(_) => fill_eta(&mut work.eta, plan, masses, contacts),
    }
    let mut eta_of_worst = vec![];
    let mut gamma = begin(std::mem::take(&mut work.gamma), contacts, plan.rolls);
    let mut op = BodyOperator {
        plan,
        contacts,
        laws: &model.laws,
        masses,
        free: if plan.has_free_column { Free::Column(free) } else { Free::Falling(Falling { model, state }) },
        joints,
        offset: if has_offsets { Offset::Column(&mut work.offset) } else { Offset::OfGap },
        recovery: Recovery::of(model),
        offset_without_slip: &work.offset_without_slip,
        last_slip: &work.last_slip,
        least_slip: model.gravity.length() * model.step,
        down: model.gravity.normalize_or_zero(),
        eta: &work.eta,
        envelope: model.envelope,
    };
    let outcome =
        solve_by(method, &mut op, (model, settings), (&mut gamma, response), (&mut work.iterates, &mut work.sweeps));
    let is_high = outcome.residual > residual_bound(model);
    if is_high && op.eta.is_empty() {
        fill_eta(&mut eta_of_worst, plan, masses, op.contacts);
        op.eta = &eta_of_worst;
    }
    work.arcs.hold(at, Linear { start: joint_start, joints: op.joints, masses }, response);
    if n == 0 {
        *joint_factor = op.joints.lasting(work.arcs.turn);
    }
    let worst = is_high.then(|| op.bodies(worst_block(&op, &gamma, response)));
    displacement.twist.clear();
    let period = recovery_period(plan, method);
    if state.steps.is_multiple_of(period) {
        overlaps::recover(&mut op, period, response, displacement);
    }
    work.gamma = keep(gamma, contacts, plan.rolls);
    (outcome, worst)
}

/// Whether a step is solved from the start: no contact has an impulse yet, or bodies have come that stand on each other, so that a good part of the
/// contacts are closed and have none.
fn begins(model: &Model, state: &State, contacts: &Contacts) -> bool {
    /// The part of the contacts.
    const PART: f64 = 0.25;
    let has_none = |i: &usize| contacts.impulse[*i] == DVec3::ZERO;
    if (0..contacts.len()).all(|i| has_none(&i)) {
        return !contacts.is_empty();
    }
    let closed = Recovery::of(model).least;
    let is_new = |i: &usize| has_none(i) && contacts.gap[*i] <= closed;
    state.has_arrivals && (0..contacts.len()).filter(is_new).count() as f64 > PART * contacts.len() as f64
}

/// The multipliers that a solve begins with: those in the columns of the contacts. Takes the memory.
fn begin(mut gamma: Vec<DVec3>, contacts: &mut Contacts, rolls: bool) -> Vec<DVec3> {
    gamma.clear();
    // Without other blocks γ is the column of contact impulses.
    if rolls {
        gamma.extend_from_slice(&contacts.impulse);
        gamma.extend_from_slice(&contacts.rolling_impulse);
    } else {
        std::mem::swap(&mut gamma, &mut contacts.impulse);
    }
    gamma
}

/// Put the multipliers of a solve into the columns of the contacts. Returns the memory.
fn keep(mut gamma: Vec<DVec3>, contacts: &mut Contacts, rolls: bool) -> Vec<DVec3> {
    let n = contacts.len();
    if rolls {
        contacts.impulse.copy_from_slice(&gamma[..n]);
        contacts.rolling_impulse.copy_from_slice(&gamma[n..2 * n]);
    } else {
        std::mem::swap(&mut gamma, &mut contacts.impulse);
    }
    gamma
}

/// Solve by a method, or by sweeps where they take over.
fn solve_by(
    method: ContactMethod,
    op: &mut BodyOperator,
    (model, settings): (&Model, &SolverSettings),
    (gamma, response): (&mut Vec<DVec3>, &mut Response),
    (iterates, sweeps): (&mut Iterates, &mut Sweeps),
) -> Outcome {
    if method == ContactMethod::Sweeps {
        return sweeps::run(op, settings, gamma, response, sweeps);
    }
    if is_taken_over(op, settings, gamma, response) {
        return sweeps::run(op, &settings.of_takeover(model.envelope), gamma, response, sweeps);
    }
    let found = solve::solve(op, settings, gamma, response, iterates);
    let is_lost = found.residual > residual_bound(model);
    if is_lost && op.plan.has_slip_feedback(method) {
        return sweep_again(op, settings, (gamma, response), (iterates, sweeps), found);
    }
    found
}

/// Whether sweeps are to take over a step, as while a bed lands or under a load: there are more contacts than iterations, and the starting
/// point γ is far enough from the solution, in the root mean square ([`StepPlan::takeover`]).
///
/// What other methods than Gauss–Seidel leave of a bed's landing, when they are cut off, are errors that whole layers share, so that layers
/// sink into each other for as long as it takes, and a load on them swings.
fn is_taken_over(op: &mut BodyOperator, settings: &SolverSettings, gamma: &[DVec3], response: &mut Response) -> bool {
    let n = gamma.len();
    let Some(bound) = op.plan.takeover else { return false };
    if n <= settings.max_iterations(n) as usize {
        return false;
    }
    if bound < 0.0 {
        return true;
    }
    op.response(gamma, response);
    residual(op, gamma, response) * (n as f64).sqrt() > bound
}

/// Where the slip that is fed back does not come to a fixed point, as where friction jams: sweeps, which know the law contact by contact. γ
/// and its response come in as what the method has found, and go out as the better of both.
fn sweep_again(
    op: &mut BodyOperator,
    settings: &SolverSettings,
    (gamma, response): (&mut [DVec3], &mut Response),
    (iterates, sweeps): (&mut Iterates, &mut Sweeps),
    found: Outcome,
) -> Outcome {
    let Iterates { best, response_best, .. } = iterates;
    best.clear();
    best.extend_from_slice(gamma);
    response_best.copy_from(response);
    op.set_slip_feedback(&vec![0.0; gamma.len()]);
    let swept = sweeps::run(op, &SolverSettings { omega: None, ..settings.clone() }, gamma, response, sweeps);
    let iterations = found.iterations + swept.iterations;
    let residual = exact::residual_of_law(op, gamma, response);
    if residual < found.residual {
        return Outcome { iterations, residual };
    }
    gamma.copy_from_slice(best);
    response.copy_from(response_best);
    Outcome { iterations, ..found }
}

/// In one of how many steps overlaps are recovered: sweeps over spheres are so fast that each step's recovery would show.
fn recovery_period(plan: &StepPlan, method: ContactMethod) -> u64 {
    match method {
        ContactMethod::Sweeps if plan.narrow == Narrow::Spheres => 4,
        _ => 1,
    }
}

impl Workspace {
    /// Release the memory of columns that the next solve lays out again.
    pub fn release(&mut self) {
        self.sweeps.release();
    }

    /// What the joints bend in the last solve's step.
    pub fn bend(&self) -> Bend {
        self.arcs.bend
    }

    /// The step length of APGD, which is part of the state.
    pub fn step_length(&mut self) -> &mut f64 {
        &mut self.iterates.step_length
    }

    /// Fill the normal parts of b. Returns whether they are a column.
    fn fill_offsets(
        &mut self,
        model: &Model,
        plan: &StepPlan,
        state: &State,
        contacts: &Contacts,
        joints: &Joints,
        method: ContactMethod,
    ) -> bool {
        let (n, offset) = (contacts.len(), &mut self.offset);
        let recovery = Recovery::of(model);
        let has_slip_feedback = plan.has_slip_feedback(method);
        let has_rows = !joints.rows.is_empty();
        // Contacts of faces come and go with each step, so that what a cut-off solve leaves of them adds up to overlaps.
        let has_faces = plan.narrow == Narrow::Any;
        if !(plan.bounces || has_slip_feedback || has_rows || has_faces) {
            return false;
        }
        // The shapes whose contacts lift.
        self.lifts.resize(model.n_shapes(), false);
        fill_rows(&mut self.lifts, |s| {
            let body = model.shape_body[s];
            let is_of_faces = model.shape_kind[s] != ShapeKind::Sphere && model.inv_mass[body as usize] > 0.0;
            has_faces && is_of_faces || joints.hold(body)
        });
        let lifts = &self.lifts;
        offset.resize(n, 0.0);
        fill_rows(offset, |i| {
            let [s, t, _] = contacts.key[i];
            let gap = contacts.gap[i];
            let opening = match lifts[s as usize] || lifts[t as usize] {
                true => recovery.lifting_rate(gap),
                false => recovery.rate(gap),
            };
            if !plan.bounces {
                return opening;
            }
            let restitution = model.laws[contacts.law[i] as usize].restitution;
            let speed = contacts.velocity(i, |b| state.twist(b)).dot(contacts.normal[i]);
            if restitution > 0.0 && bounces(model, gap, speed) { opening.min(restitution * speed) } else { opening }
        });
        if has_slip_feedback {
            self.offset_without_slip.clone_from(offset);
            self.last_slip.clear();
            self.last_slip.resize(n, 0.0);
            fill_rows(&mut self.last_slip, |i| {
                let (v, normal) = (contacts.velocity(i, |b| state.twist(b)), contacts.normal[i]);
                model.laws[contacts.law[i] as usize].friction * (v - normal * v.dot(normal)).length()
            });
        }
        true
    }
}

/// Fill η of the blocks.
fn fill_eta(eta: &mut Vec<f64>, plan: &StepPlan, masses: &Masses, contacts: &Contacts) {
    let n = contacts.len();
    let rolls = if plan.rolls { n } else { 0 };
    eta.resize(n + rolls, 0.0);
    fill_rows(eta, |i| {
        if i < n {
            masses.eta(contacts, i)
        } else {
            let [a, b] = contacts.bodies[i - n].map(|b| masses.inv_inertia(b as usize));
            let m = a + b;
            3.0 / (m.x_axis.x + m.y_axis.y + m.z_axis.z)
        }
    });
}
