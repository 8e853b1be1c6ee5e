//! The watch over a run: checks of every step, so that nothing goes wrong silently.
//!
//! | warning | when |
//! |---|---|
//! | residual | the step's residual is above 100 tolerances and above gravity times step size, or without gravity a thousandth of the speeds' root mean square |
//! | joint | the error of a locked motion is above a thousandth of the initial bounding box's diagonal, or a hundredth of a radian |
//! | motor | a driven rate is off by more than a hundredth of what is prescribed, and by more than half of it or what gives five times the error above in 1 s; or a driven coordinate by more than that error |
//! | energy | kinetic, potential and elastic energy have grown by more than a tenth of the available energy beyond what motors and loads have given; or while nothing but joints, motors and loads acted, they have fallen by more than a tenth of the maximum kinetic energy below that |
//! | overlap | two bodies overlap by more than half the smaller inradius of their shapes; on a device, of all shapes that move |
//!
//! What motors, loads, and lengths and preloads that change give is known step by step (`work.rs`): energy less that is compared with its
//! minimum, since the last step in which a body has appeared or begun to move, or a joint or spring has begun or ended to act. A hundredth of
//! what was given and taken meanwhile is tolerated, and what the forces that gave it do at the bound of residuals. Available energy is kinetic energy, elastic
//! energy, and each body's potential energy over the bottom of the initial bounding box, or over its own lowest position if that is
//! lower, plus its weight times its minimum radius of gyration. Steps that are explicit in the positions let energy oscillate by h F·v/2,
//! where F are weight and springs' forces: an oscillation of twice that is tolerated. A position, velocity, residual or joint error that
//! is not finite, or a speed above 10⁵ m/s, ends a run ([`Broken`]).

use crate::inertia::{gyration, is_isotropic};
use crate::joint::{Coordinate, Joint, JointState, Motor};
use crate::model::Model;
use crate::outcome::{Deepest, JointErrors, StepOutcome};
use crate::rows::fold_rows;
use crate::state::{Activity, State};
use crate::swing;
use crate::work;
use glam::DVec3;

pub use crate::warning::{Broken, Warning, WarningCount, WarningKind, WatchState};

/// Speed of a body above which a run has diverged, m/s.
const MAX_SPEED: f64 = 1e5;
/// Tolerance of joint errors that are lengths, over the bounding box's diagonal.
const JOINT_ERROR: f64 = 1e-3;
/// Tolerance of joint errors that are angles, rad.
const JOINT_ANGLE: f64 = 1e-2;
/// Turn in a step from which on it may be what a joint does not follow, rad.
const TURN: f64 = 0.2;
/// Tolerance of errors of driven rates, over the prescribed rate: of fast motors, and at most, of slow ones.
const MOTOR_RATE: [f64; 2] = [1e-2, 0.5];
/// Share of a step within which a time is that of a jump: what rounding makes of it.
const JUMP: f64 = 1e-6;
/// Tolerance of errors of driven rates within 1 s, over that of errors of joints.
const MOTOR_DRIFT: f64 = 5.0;
/// Rate up to which a motor at its maximum effort stands still, over that tolerance.
const STALLED: f64 = 1e-4;
/// Prescribed rate up to which a motor is a brake, over that tolerance.
const SLOWEST: f64 = 1e-3;
/// Tolerance of energy growth, over the available energy.
const ENERGY_GROWTH: f64 = 0.1;
/// Tolerance of energy that joints lose, over the maximum kinetic energy.
const ENERGY_LOSS: f64 = 0.1;
/// What the change of springs' forces within a step adds to the oscillation of energy, at most, over the kinetic energy: what is more is unstable.
const STRETCHED: f64 = 0.2;
/// Tolerance of both, over the work that was given and taken meanwhile.
const OF_WORK: f64 = 0.01;

/// Tolerance of overlaps, over the smaller inradius.
const OVERLAP: f64 = 0.5;

/// [`SolverSettings::residual_bound`](crate::settings::SolverSettings::residual_bound) of a model's steps, m/s.
pub fn residual_bound(model: &Model) -> f64 {
    model.solver.residual_bound(model.gravity.length() * model.step)
}

/// The residual that counts as little without gravity, m/s: a part of the root mean square of the speeds; 0 with gravity.
fn speed_bound(model: &Model, survey: &Survey) -> f64 {
    /// The part.
    const PART: f64 = 1e-3;
    let is_weightless = model.gravity == DVec3::ZERO && survey.mass > 0.0;
    if is_weightless { PART * (2.0 * survey.kinetic / survey.mass).sqrt() } else { 0.0 }
}

/// What the error of the work that was given in a step may come to, J: a part of it, and what drives the model at the error of velocities.
fn doubt(model: &Model, state: &State, seen: &StepOutcome) -> f64 {
    OF_WORK * seen.work + model.step * residual_bound(model) * work::forces(model, state)
}

/// Sums and maxima over the bodies.
#[derive(Clone, Copy, Debug)]
pub struct Survey {
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Potential energy, J.
    pub potential: f64,
    /// Potential energy over the bodies' lowest positions, J.
    pub over_lowest: f64,
    /// Bound of the energy oscillation of weight: h |F·v|, summed, J.
    pub oscillation: f64,
    /// Mass of the moving bodies, kg.
    pub mass: f64,
    /// Body with the maximum squared speed, and that, m²/s²; infinite where the body's state is not finite.
    pub fastest: (usize, f64),
    /// Body with the maximum kinetic energy, and that, J.
    pub most_energetic: (usize, f64),
}

impl Survey {
    const EMPTY: Survey = Survey {
        kinetic: 0.0,
        potential: 0.0,
        over_lowest: 0.0,
        oscillation: 0.0,
        mass: 0.0,
        fastest: (0, 0.0),
        most_energetic: (0, 0.0),
    };

    /// Survey all bodies, and update their lowest potentials.
    fn of(model: &Model, state: &State, lowest: &mut [f64]) -> Survey {
        let body = |mut sum: Survey, b: usize, lowest: &mut f64| {
            if !state.is_free(b) {
                return sum;
            }
            let (mass, inv_inertia) = (1.0 / model.inv_mass[b], model.inv_inertia[b]);
            let (v, w) = (state.velocity[b], state.angular_velocity[b]);
            let rotational = if is_isotropic(inv_inertia) {
                w.length_squared() / inv_inertia.x
            } else {
                (w * w / inv_inertia).element_sum()
            };
            let speed2 = v.length_squared();
            let kinetic = 0.5 * (mass * speed2 + rotational);
            let height = -model.gravity.dot(state.position[b]);
            sum.kinetic += kinetic;
            sum.potential += mass * height;
            *lowest = lowest.min(height);
            sum.over_lowest += mass * (height - *lowest);
            sum.oscillation += mass * (model.step * model.gravity.dot(v)).abs();
            sum.mass += mass;
            // A state that is not finite makes these not finite.
            let is_finite = (kinetic + height).is_finite() && state.position[b].is_finite();
            sum.merge_fastest((b, if is_finite { speed2 } else { f64::INFINITY }));
            sum.merge_most_energetic((b, kinetic));
            sum
        };
        fold_rows(lowest, || Survey::EMPTY, body, Survey::merge)
    }

    fn merge_fastest(&mut self, other: (usize, f64)) {
        if other.1 > self.fastest.1 {
            self.fastest = other;
        }
    }

    fn merge_most_energetic(&mut self, other: (usize, f64)) {
        if other.1 > self.most_energetic.1 {
            self.most_energetic = other;
        }
    }

    fn merge(mut self, other: Survey) -> Survey {
        self.kinetic += other.kinetic;
        self.potential += other.potential;
        self.over_lowest += other.over_lowest;
        self.oscillation += other.oscillation;
        self.mass += other.mass;
        self.merge_fastest(other.fastest);
        self.merge_most_energetic(other.most_energetic);
        self
    }
}

impl WatchState {
    /// Record the reference values of the initial state, before the first step; a resumed run has them already.
    pub fn start(&mut self, model: &Model, state: &State) {
        if self.diagonal != 0.0 {
            return;
        }
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut include = |p: DVec3, half: DVec3| (min, max) = (min.min(p - half), max.max(p + half));
        for s in (0..model.n_shapes()).filter(|s| !model.shape_kind[*s].is_surface()) {
            let place = state.shape_pose(model, s);
            include(place.position, DVec3::splat(model.shape_size[s].max_element()));
        }
        for b in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
            include(state.position[b], DVec3::splat(gyration(model.inv_mass[b], model.inv_inertia[b].min_element())));
        }
        for joint in &model.joints {
            let frames = state.joint_frames(joint);
            include(frames.a.position, DVec3::ZERO);
            include(frames.b.position, DVec3::ZERO);
        }
        if !(min.cmple(max).all()) {
            (min, max) = (DVec3::ZERO, DVec3::ZERO);
        }
        let diagonal = (max - min).length();
        // What has no extent, as a point on its joint, is taken for a metre.
        self.diagonal = if diagonal > 0.0 { diagonal } else { 1.0 };
        let bottom = DVec3::select(model.gravity.cmpgt(DVec3::ZERO), max, min);
        self.lowest = vec![-model.gravity.dot(bottom); model.n_bodies()];
        let survey = Survey::of(model, state, &mut self.lowest);
        (self.mass, self.by_size) = (survey.mass, energy_by_size(model, state));
        self.acting = acting(model, state.time);
        // The elastic energy of springs is known after the first step.
        let energy = survey.kinetic + survey.potential;
        self.min_energy = if model.springs.is_empty() { energy } else { f64::INFINITY };
    }

    /// Survey the bodies after a step.
    pub fn survey(&mut self, model: &Model, state: &State) -> Survey {
        Survey::of(model, state, &mut self.lowest)
    }

    /// Check a step by a survey of its bodies. Returns its warnings, which are counted, and the reason why the run cannot go on, if there
    /// is one.
    pub fn check(
        &mut self,
        model: &Model,
        state: &State,
        (seen, survey): (&StepOutcome, &Survey),
    ) -> (Vec<Warning>, Option<Broken>) {
        let broken = broken(seen, survey);
        if broken.is_some() {
            return (vec![], broken);
        }
        let is_switched = self.is_switched(model, state, survey.mass);
        let found = [
            self.residual(model, (seen, survey)).map(|m| (WarningKind::Residual, m)),
            self.joint(model, state, seen).map(|m| (WarningKind::Joint, m)),
            self.motor(model, state).map(|m| (WarningKind::Motor, m)),
            self.energy(model, state, (seen, survey), is_switched)
                .or_else(|| self.lost_energy(model, state, (seen, survey), is_switched))
                .map(|m| (WarningKind::Energy, m)),
            self.overlap(model, seen).map(|m| (WarningKind::Overlap, m)),
            swing::watch(&mut self.swings, model, state, |b| label(model, b)).map(|m| (WarningKind::Swing, m)),
        ];
        let warning = |(kind, message)| Warning { kind, step: state.steps, time: state.time, message };
        let warnings: Vec<Warning> = found.into_iter().flatten().map(warning).collect();
        warnings.iter().for_each(|w| self.count(w));
        (warnings, None)
    }

    fn count(&mut self, warning: &Warning) {
        match self.warnings.iter_mut().find(|w| w.first.kind == warning.kind) {
            Some(known) => known.count += 1,
            None => self.warnings.push(WarningCount { count: 1, first: warning.clone() }),
        }
    }

    fn residual(&self, model: &Model, (seen, survey): (&StepOutcome, &Survey)) -> Option<String> {
        let (residual, bound) = (seen.solver.residual, residual_bound(model).max(speed_bound(model, survey)));
        (residual > bound).then(|| {
            let at = seen.worst.map_or(String::new(), |[a, b]| {
                format!("; it is greatest between body {} and body {}", label(model, a), label(model, b))
            });
            format!("the solver has not converged: its residual is {residual:.3e} m/s, above {bound:.3e} m/s{at}")
        })
    }

    fn joint(&self, model: &Model, state: &State, seen: &StepOutcome) -> Option<String> {
        let JointErrors { length, angle } = seen.joints;
        let named = |joint: usize| joint_label(model, &model.joints[joint]);
        let too_fast = |joint: usize| {
            let joint = &model.joints[joint];
            turn_message(model, state, joint) + pull_message(joint)
        };
        let bound = JOINT_ERROR * self.diagonal;
        if length.1 > bound {
            let of = "a thousandth of the initial bounding box's diagonal";
            let (name, why) = (named(length.0), too_fast(length.0));
            return Some(format!("{name} is violated by {:.3e} m, above {bound:.3e} m, {of}{why}", length.1));
        }
        let (joint, error) = angle;
        (error > JOINT_ANGLE).then(|| {
            let (name, why) = (named(joint), too_fast(joint));
            format!("{name} is violated by {error:.3e} rad, above {JOINT_ANGLE} rad{why}")
        })
    }

    /// Say what is to be known of a step and is no fault: of a motor that stands still, or of the first step that is taken in parts.
    pub fn note(&mut self, model: &Model, state: &State, seen: &StepOutcome) -> Option<Warning> {
        let of = |kind, message| Warning { kind, step: state.steps, time: state.time, message };
        if let Some(message) = self.stalled(model, state) {
            return Some(of(WarningKind::Motor, message));
        }
        if seen.parts <= 1 || self.has_parts {
            return None;
        }
        self.has_parts = true;
        let on_joints = model.joints.iter().flat_map(|joint| joint.bodies);
        let rate = |b: &u32| state.angular_velocity[*b as usize].length();
        let fastest = on_joints.max_by(|a, b| rate(a).total_cmp(&rate(b)))?;
        let (parts, turn, named) = (seen.parts, rate(&fastest) * model.step, label(model, fastest));
        // What is jerked does not turn at the end of its step.
        let turns = if turn < 0.01 { String::new() } else { format!(", in which body {named} turns by {turn:.2} rad") };
        Some(of(
            WarningKind::Joint,
            format!(
                "joints bend too much for a whole step{turns}: it was taken in {parts} parts, as others will be (`parts` of report.csv)"
            ),
        ))
    }

    /// A message about a motor that stands still or is driven back at its maximum effort: once in a run of each of the first few, since that is what
    /// they are asked for.
    fn stalled(&mut self, model: &Model, state: &State) -> Option<String> {
        /// The most motors that are spoken of.
        const MOST: usize = 5;
        if self.noted.len() == MOST || model.joints.iter().all(|joint| joint.max_effort.is_none()) {
            return None;
        }
        let is_new = |i: &usize| model.joints[*i].max_effort.is_some() && !self.noted.contains(&(*i as u32));
        let stalls = |i: &usize| {
            let (joint, now) = (&model.joints[*i], &state.joints[*i]);
            now.motor_side != 0.0 && now.rate * now.motor_side <= STALLED * MOTOR_DRIFT * self.scale(joint)
        };
        let lag = |i: usize| self.lag(model, state, i).map(|(_, message)| (i, message));
        let (joint, message) = (0..model.joints.len()).filter(is_new).filter(stalls).find_map(lag)?;
        self.noted.push(joint as u32);
        Some(format!("{message}; this is said once of each motor, of the first few"))
    }

    /// The motor without a maximum effort that is farthest from what it prescribes, of those beyond their bounds.
    fn motor(&self, model: &Model, state: &State) -> Option<String> {
        let any_effort = (0..model.joints.len()).filter(|i| model.joints[*i].max_effort.is_none());
        let lags = any_effort.filter_map(|i| self.lag(model, state, i));
        lags.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, message)| message)
    }

    /// The error of a coordinate that counts, rad or m.
    fn scale(&self, joint: &Joint) -> f64 {
        let is_angle = joint.kind.coordinate() == Some(Coordinate::Angle);
        if is_angle { JOINT_ANGLE } else { JOINT_ERROR * self.diagonal }
    }

    /// How far a joint's motor is from what it prescribes, over its bound, and a message; none within it.
    fn lag(&self, model: &Model, state: &State, i: usize) -> Option<(f64, String)> {
        let (joint, now) = (&model.joints[i], &state.joints[i]);
        let moves = joint.bodies.iter().any(|b| state.moves(*b as usize));
        let is_present = moves && !joint.bodies.iter().any(|b| state.is_inactive(*b as usize));
        let acts = is_present && joint.acts(state.time - model.step);
        // What jumps at the step's end has either value: the last bits of the time say which one was solved for.
        let just_before = state.time - JUMP * model.step;
        let driven = [state.time, just_before].into_iter().filter_map(|t| joint.driven(now, t));
        let off = |[goal, is]: &[f64; 2]| (is - goal).abs();
        let [goal, is] = driven.min_by(|a, b| off(a).total_cmp(&off(b))).filter(|_| acts)?;
        let is_rate = matches!(joint.motor, Some(Motor::Speed(_)));
        let scale = self.scale(joint);
        let [fast, slow] = MOTOR_RATE.map(|share| share * goal.abs());
        let drift = MOTOR_DRIFT * scale;
        // A brake, and what goes through zero, as a sine.
        let slow = if goal.abs() < SLOWEST * drift { drift } else { slow };
        let bound = if is_rate { fast.max(drift.min(slow)) } else { scale };
        let excess = (is - goal).abs() / bound;
        (excess > 1.0).then(|| (excess, lag_message(model, joint, (now, state.time), [goal, is], bound)))
    }

    fn energy(
        &mut self,
        model: &Model,
        state: &State,
        (seen, survey): (&StepOutcome, &Survey),
        is_switched: bool,
    ) -> Option<String> {
        let elastic = state.elastic_energy(model);
        let energy = survey.kinetic + survey.potential + elastic - state.work();
        let of_springs = seen.spring_oscillation + seen.spring_stretch.min(STRETCHED * survey.kinetic);
        let oscillation = survey.oscillation + of_springs;
        let upper = energy + oscillation;
        if is_switched || upper < self.min_energy {
            (self.min_energy, self.doubt) = (upper, 0.0);
            return None;
        }
        self.doubt += doubt(model, state, seen);
        // The error of velocities, m/s.
        let error = residual_bound(model);
        let available = survey.kinetic + survey.over_lowest + self.by_size + elastic.abs();
        let bound = ENERGY_GROWTH * available + self.doubt + 2.0 * survey.mass * error * error;
        let growth = energy - oscillation - self.min_energy;
        if !(growth > bound) {
            return None;
        }
        let source = if self.doubt > 0.0 { "beyond what motors and loads have given" } else { "without a cause" };
        (self.min_energy, self.doubt) = (upper, 0.0);
        let (body, own) = survey.most_energetic;
        let message = format!(
            "energy has grown by {growth:.3e} J {source}; the available energy is {available:.3e} J, the kinetic energy of body {} {own:.3e} J",
            label(model, body as u32)
        );
        let overlap = seen.worst_penetration;
        if overlap > 0.0 {
            return Some(format!(
                "{message}; the recovery of overlaps lifts bodies, the maximum penetration is {overlap:.3e} m"
            ));
        }
        Some(message)
    }

    /// Energy that is lost while nothing acts but joints without limits, which take none, motors and loads: where the step does not resolve how fast the links of a
    /// mechanism turn, as when it passes a straight line. What hardly turns has lost it as joints without slack came taut, which is an impact.
    fn lost_energy(
        &mut self,
        model: &Model,
        state: &State,
        (seen, survey): (&StepOutcome, &Survey),
        is_switched: bool,
    ) -> Option<String> {
        /// Steps of free fall whose speed is that of the start, when links begin to carry.
        const START: f64 = 30.0;
        /// Turn in a step that it resolves, rad.
        const RESOLVED: f64 = 0.03;
        let can_lose = is_switched
            || model.joints.is_empty()
            || !model.springs.is_empty()
            || model.joints.iter().any(|j| j.limits.is_some() && j.locked_at().is_none())
            || !state.contacts.is_empty()
            || state.activity.contains(&Activity::Asleep);
        if can_lose {
            self.kept = None;
            return None;
        }
        let energy = survey.kinetic + survey.potential - state.work();
        let [most, fastest, turned, before] = self.kept.unwrap_or([f64::NEG_INFINITY, 0.0, 0.0, 0.0]);
        let on_joints = model.joints.iter().flat_map(|joint| joint.bodies);
        let rates = on_joints.map(|b| state.angular_velocity[b as usize].length());
        let turned = (model.step * rates.fold(0.0, f64::max)).max(turned);
        let (most, fastest) = (most.max(energy - survey.oscillation), fastest.max(survey.kinetic));
        let doubt = before + doubt(model, state, seen);
        self.kept = Some([most, fastest, turned, doubt]);
        let slow = START * residual_bound(model);
        let loss = most - energy - survey.oscillation;
        if !(loss > ENERGY_LOSS * fastest + doubt + 0.5 * survey.mass * slow * slow) {
            return None;
        }
        self.kept = None;
        if turned < RESOLVED {
            return None;
        }
        Some(format!(
            "energy has fallen by {loss:.3e} J although nothing but joints acts, the maximum kinetic energy was {fastest:.3e} J: the step is too long for how fast links turn, by up to {turned:.2} rad in it"
        ))
    }

    fn overlap(&mut self, model: &Model, seen: &StepOutcome) -> Option<String> {
        if !self.may_be_deep(model, seen.worst_penetration) {
            return None;
        }
        let Some(deepest) = seen.deepest else {
            let of = "half the least inradius of what moves";
            return Some(format!("two bodies overlap by {:.3e} m, more than {of}", seen.worst_penetration));
        };
        let Deepest { bodies, depth, inradius } = deepest;
        let [a, b] = bodies.map(|b| label(model, b));
        let share = deepest.share();
        (share > OVERLAP).then(|| {
            format!(
                "bodies {a} and {b} overlap by {depth:.3e} m, {share:.2} of the smaller one's inradius of {inradius:.3e} m"
            )
        })
    }

    /// Whether an overlap may be too deep, by its depth, m.
    pub fn may_be_deep(&mut self, model: &Model, depth: f64) -> bool {
        let least = *self.inradius.get_or_insert_with(|| {
            let moves = |s: &usize| model.inv_mass[model.shape_body[*s] as usize] > 0.0;
            (0..model.n_shapes()).filter(moves).map(|s| model.inradius(s)).fold(f64::INFINITY, f64::min)
        });
        depth > OVERLAP * least
    }

    /// Whether a body has appeared or begun to move, or a joint or spring has begun or ended to act, in the step.
    fn is_switched(&mut self, model: &Model, state: &State, mass: f64) -> bool {
        let acting = acting(model, state.time - model.step);
        let is_switched = acting != self.acting || mass != self.mass;
        if mass != self.mass {
            (self.mass, self.by_size) = (mass, energy_by_size(model, state));
        }
        self.acting = acting;
        is_switched
    }
}

/// Whether each joint, then each spring, acts at a time, s.
fn acting(model: &Model, t: f64) -> Vec<bool> {
    model.joints.iter().map(|j| j.acts(t)).chain(model.springs.iter().map(|s| s.acts(t))).collect()
}

fn broken(seen: &StepOutcome, survey: &Survey) -> Option<Broken> {
    let (body, speed) = (Some(survey.fastest.0), survey.fastest.1.sqrt());
    if speed == f64::INFINITY {
        return Some(Broken { body, why: "its state is not finite".into() });
    }
    if speed > MAX_SPEED {
        return Some(Broken { body, why: format!("it moves at {speed:.3e} m/s") });
    }
    let residual = seen.solver.residual;
    if !residual.is_finite() {
        return Some(Broken { body: None, why: format!("the solver's residual is {residual} m/s") });
    }
    let JointErrors { length, angle } = seen.joints;
    let is_finite = length.1.is_finite() && angle.1.is_finite();
    (!is_finite).then(|| Broken { body: None, why: "the joints' errors are not finite".into() })
}

/// Sum of weight times minimum radius of gyration of the moving bodies, J.
fn energy_by_size(model: &Model, state: &State) -> f64 {
    let free = (0..model.n_bodies()).filter(|b| state.is_free(*b));
    let size = |b: usize| gyration(model.inv_mass[b], model.inv_inertia[b].max_element()) / model.inv_mass[b];
    model.gravity.length() * free.map(size).sum::<f64>()
}

/// Message about a motor that prescribes `goal` where the joint has `is` at time `t`, s, beyond `bound`; says what the motor gives at most, or how to
/// bound that, and whether the joint is at a limit.
fn lag_message(model: &Model, joint: &Joint, (now, t): (&JointState, f64), [goal, is]: [f64; 2], bound: f64) -> String {
    let is_angle = joint.kind.coordinate() == Some(Coordinate::Angle);
    let (what, per) = match joint.motor {
        Some(Motor::Speed(_)) => ("rate", "/s"),
        _ => ("coordinate", ""),
    };
    let (unit, effort, key) = if is_angle { ("rad", "N m", "max_torque") } else { ("m", "N", "max_force") };
    let near = 2.0 * model.step * now.rate.abs() + if is_angle { JOINT_ANGLE } else { 1e-3 };
    let limit = joint.limits.and_then(|l| l.into_iter().find(|l| (now.coordinate - l).abs() <= near));
    let limit = limit.map_or(String::new(), |l| format!("; the joint is at its limit of {l} {unit}"));
    let named = joint_label(model, joint);
    let off = format!("the {what} is {is:.3e} {unit}{per} instead of {goal:.3e} {unit}{per}");
    match joint.max_effort(t - 0.5 * model.step) {
        Some(most) => format!(
            "the motor of {named} does not reach what it prescribes with its `{key}` of {most:.3e} {effort}: {off}{limit}"
        ),
        None => format!(
            "the motor of {named} does not reach what it prescribes: {off}, off by more than {bound:.3e} {unit}{per}{limit}; a `{key}` would bound what it gives"
        ),
    }
}

/// What is to be said of a joint on which a body turns too far in a step: how far, and a step that resolves it; nothing of others.
fn turn_message(model: &Model, state: &State, joint: &Joint) -> String {
    let rate = |body: &u32| state.angular_velocity[*body as usize].length();
    let fastest = joint.bodies.iter().max_by(|a, b| rate(a).total_cmp(&rate(b)));
    let Some(body) = fastest.filter(|b| rate(b) * model.step > TURN) else { return String::new() };
    let turn = rate(body) * model.step;
    let step = model.step * TURN / turn;
    format!(
        "; body {} turns by {turn:.2} rad in a step: take steps of {step:.1e} s, or a lower speed",
        label(model, *body)
    )
}

/// What is to be said of a joint whose motor may pull it apart.
fn pull_message(joint: &Joint) -> &'static str {
    let is_driven = matches!(joint.motor, Some(Motor::Speed(_) | Motor::Position(_))) && joint.max_effort.is_none();
    match joint.kind.coordinate().filter(|_| is_driven) {
        Some(Coordinate::Angle) => "; its motor gives any torque that it needs: `max_torque` bounds it",
        Some(_) => "; its motor gives any force that it needs: `max_force` bounds it",
        None => "",
    }
}

fn joint_label(model: &Model, joint: &Joint) -> String {
    let [a, b] = joint.bodies.map(|b| label(model, b));
    format!("joint `{}` of bodies {a} and {b}", joint.name)
}

fn label(model: &Model, body: u32) -> String {
    model.body_label(body as usize)
}
