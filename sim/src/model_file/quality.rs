//! Quality levels: a step and a solver for what a model file leaves open of them, from the sizes and the kind of what moves.
//!
//! What moves falls by its least half length r in the time √(r/g), which is the measure of the step. The numbers were measured on beds,
//! piles, pyramids and machines (`benches/convex.rs`).

use super::types::ModelFile;
use crate::heap::carries_loads;
use crate::inertia::gyration;
use crate::joint::{Coordinate, Joint, Motor};
use crate::model::Model;
use crate::plan::{Narrow, coheres, has_joints};
use crate::settings::{FrictionLaw, Method, Quality, SolverSettings};
use crate::spring_rates;
use crate::state::State;
use frame::Fault;
use frame::yaml::Document;
use std::collections::BTreeSet;

/// The envelope of bodies of any shape over g h²: what loses its support falls by less before it is back, with the points that it had.
const FALLS: f64 = 15.0;

/// Speed below which bodies of any shape come to rest, over g h: what slows them there is at most a quarter of this share of their weight.
const RESTS: f64 = 2e-3;

/// Residual of slow bodies of any shape to which they are swept, over g h: a sixteenth of what comes to rest.
const SETTLES: f64 = RESTS / 16.0;

/// Spheres that move up to which the first solve is long: pyramids of them stand by it, and on a device the processor looks at each step for it.
const FEW_GRAINS: usize = 2000;

/// The half length of what moves where it has no shape, at most, m.
const UNKNOWN: f64 = 0.1;
/// Sweeps over spheres at normal quality.
pub const NORMAL_SWEEPS: u32 = 8;
/// Relaxation factor of sweeps over spheres at normal quality.
pub const NORMAL_OMEGA: f64 = 1.5;
/// Overlap of spheres that a step may add at normal quality, over r.
pub const NORMAL_OVERLAP: f64 = 3.1e-4;

/// The kinds of models between which the choice differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Spheres without joints.
    Grains,
    /// Bodies of any shapes without joints and cohesion.
    Bodies,
    /// Anything else.
    Any,
}

/// The choice for a level and a kind.
struct Choice {
    /// Step over √(r/g).
    step: f64,
    /// Longest step, s.
    longest: f64,
    method: Method,
    friction: FrictionLaw,
    iterations: Option<u32>,
    start_iterations: Option<u32>,
    /// Overlap that a step may add, over r.
    overlap: Option<f64>,
    /// Whether slow bodies are swept on.
    settles: bool,
    tolerance: f64,
    omega: Option<f64>,
    /// Greatest speed of recovery over √(g r).
    recovery: Option<f64>,
    /// Gap of rest and motion without a new collision, over r.
    near: Option<[f64; 2]>,
}

impl Choice {
    fn of(quality: Quality, kind: Kind) -> Choice {
        use Quality::*;
        let level = |draft: f64, normal: f64, tight: f64| match quality {
            Draft => draft,
            Normal => normal,
            Tight => tight,
        };
        let count = |draft: u32, normal: u32, tight: u32| level(draft.into(), normal.into(), tight.into()) as u32;
        match kind {
            Kind::Grains => Choice {
                step: level(0.034, 0.017, 0.0085),
                longest: level(4e-3, 2e-3, 1e-3),
                method: Method::GaussSeidel,
                friction: FrictionLaw::Exact,
                iterations: Some(count(10, NORMAL_SWEEPS, 60)),
                start_iterations: Some(400),
                overlap: Some(level(1e-3, NORMAL_OVERLAP, NORMAL_OVERLAP)),
                settles: false,
                tolerance: level(1e-7, 1e-8, 1e-9),
                omega: Some(level(NORMAL_OMEGA, NORMAL_OMEGA, 1.0)),
                recovery: Some(0.035),
                near: None,
            },
            Kind::Bodies => Choice {
                step: level(0.16, 0.09, 0.02),
                longest: level(1.0 / 60.0, 1.0 / 120.0, 1.0 / 480.0),
                method: Method::GaussSeidel,
                friction: FrictionLaw::Relaxed,
                iterations: Some(count(15, 15, 40)),
                start_iterations: Some(count(2000, 2000, 4000)),
                overlap: None,
                settles: true,
                tolerance: 1e-9,
                omega: Some(1.3),
                recovery: None,
                near: Some([level(2e-3, 1e-3, 1e-3), level(5e-3, 2e-3, 4e-4)]),
            },
            Kind::Any => Choice {
                step: level(0.08, 0.04, 0.01),
                longest: level(1.0 / 60.0, 1.0 / 120.0, 1.0 / 500.0),
                method: Method::Apgd,
                friction: FrictionLaw::Relaxed,
                iterations: None,
                start_iterations: None,
                overlap: None,
                settles: false,
                tolerance: level(1e-6, 1e-7, 1e-8),
                omega: None,
                recovery: None,
                near: None,
            },
        }
    }
}

/// What the choice depends on besides the level.
struct Scale {
    kind: Kind,
    /// Least half length of a shape that moves, or of a moving body without shapes, m.
    radius: f64,
    /// Gravity, m/s².
    gravity: f64,
    /// Greatest speed at the start, m/s.
    speed: f64,
    /// Greatest rate at which what is on joints turns at the start, or is driven, rad/s.
    turning: f64,
    /// Greatest rate at which springs let bodies swing, rad/s.
    swinging: f64,
    /// Number of shapes that move.
    n_shapes: usize,
}

/// Sizes of the moving bodies without shapes, m: their radii of gyration. Points, far smaller than the others, have none.
fn sizes_without_shapes(model: &Model) -> impl Iterator<Item = f64> {
    /// Size over the greatest of them, below which a body is a point.
    const POINT: f64 = 1e-3;
    let has_shapes: BTreeSet<u32> = model.shape_body.iter().copied().collect();
    let bare = (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0 && !has_shapes.contains(&(*b as u32)));
    let size: Vec<f64> = bare.map(|b| gyration(model.inv_mass[b], model.inv_inertia[b].min_element())).collect();
    let most = size.iter().copied().fold(0.0, f64::max);
    size.into_iter().filter(move |size| *size > POINT * most).map(|size| size.min(UNKNOWN))
}

/// Part of its least half length that a body may move by in a step at the start: half of the way of a step is how far it comes to rest too early.
fn way(quality: Quality) -> f64 {
    match quality {
        Quality::Draft => 1.0,
        Quality::Normal | Quality::Tight => 0.45,
    }
}

/// Angle by which what is on joints may turn in a step, rad: joints hold on the arcs of the step, and links that turn far faster than what drives
/// them still do.
fn turn(quality: Quality) -> f64 {
    match quality {
        Quality::Draft => 0.5,
        Quality::Normal => 0.25,
        Quality::Tight => 0.125,
    }
}

/// Angle by which springs may let bodies swing in a step, rad: their energy swings by half of that, over the greatest.
fn swing(quality: Quality) -> f64 {
    match quality {
        Quality::Draft => 0.3,
        Quality::Normal => 0.15,
        Quality::Tight => 0.05,
    }
}

/// The least share of a step to which turning and springs make it shorter: motors that are far too fast by mistake are to be seen within a bearable
/// time, and springs that are far too stiff hold as if they were rigid.
const SHORTEST: f64 = 1.0 / 16.0;

/// Greatest rate at which bodies on joints turn at the start, or motors turn them, rad/s.
fn turning(model: &Model, state: &State) -> f64 {
    let of = |joint: &Joint| {
        let is_angle = joint.kind.coordinate() == Some(Coordinate::Angle);
        let driven = match joint.motor.as_ref().filter(|_| is_angle) {
            Some(Motor::Speed(speed)) => speed.greatest(),
            Some(Motor::Position(goal)) => goal.steepest(),
            _ => 0.0,
        };
        joint.bodies.iter().map(|b| state.angular_velocity[*b as usize].length()).fold(driven, f64::max)
    };
    model.joints.iter().map(of).fold(0.0, f64::max)
}

impl Scale {
    fn of(model: &Model, state: &State) -> Scale {
        // Those that come later, too.
        let mut awake = State { time: f64::INFINITY, ..state.clone() };
        awake.wake(model);
        let kind = match Narrow::of(model, &awake) {
            _ if has_joints(model) || carries_loads(model, &awake) => Kind::Any,
            Narrow::Spheres => Kind::Grains,
            // The envelope that bodies of any shape rest with would be the range of their cohesion.
            Narrow::Any if coheres(model) => Kind::Any,
            Narrow::Any => Kind::Bodies,
        };
        let moves = |s: &usize| model.inv_mass[model.shape_body[*s] as usize] > 0.0;
        let of_shapes = (0..model.n_shapes()).filter(moves).map(|s| model.shape_size[s].min_element());
        let radius = of_shapes.chain(sizes_without_shapes(model)).fold(f64::INFINITY, f64::min);
        let speed = state.velocity.iter().fold(0.0f64, |most, v| most.max(v.length()));
        let gravity = model.gravity.length();
        Scale {
            kind,
            radius: if radius.is_finite() && radius > 0.0 { radius } else { UNKNOWN },
            gravity: if gravity > 0.0 { gravity } else { 9.81 },
            speed,
            turning: turning(model, state),
            swinging: spring_rates::rates(model, state).iter().fold(0.0, |most, rate| rate.most.max(most)),
            n_shapes: (0..model.n_shapes()).filter(moves).count(),
        }
    }
}

impl Quality {
    /// The step, s, and the settings of the solver that the level chooses for a model and its initial state; for a `given` step, s, if there is one.
    pub fn settings(self, model: &Model, state: &State, given: Option<f64>) -> (f64, SolverSettings) {
        let Scale { kind, radius, gravity, speed, turning, swinging, n_shapes } = Scale::of(model, state);
        let starts = kind != Kind::Grains || n_shapes <= FEW_GRAINS;
        let choice = Choice::of(self, kind);
        let by_speed = if speed > 0.0 { way(self) * radius / speed } else { f64::INFINITY };
        let by_size = (choice.step * (radius / gravity).sqrt()).min(choice.longest);
        let by_rate =
            |angle: f64, rate: f64| if rate > 0.0 { (angle / rate).max(SHORTEST * by_size) } else { f64::INFINITY };
        let by_rates = by_rate(turn(self), turning).min(by_rate(swing(self), swinging));
        let chosen = by_size.min(by_speed).min(by_rates);
        let step = given.unwrap_or(chosen);
        let open = SolverSettings::default();
        let fall = gravity * step * step;
        let solver = SolverSettings {
            method: Some(choice.method),
            friction: choice.friction,
            iterations: choice.iterations,
            start_iterations: choice.start_iterations.filter(|_| starts),
            overlap_tolerance: choice.overlap.map(|overlap| overlap * radius),
            settling_tolerance: Some(SETTLES * model.gravity.length() * step)
                .filter(|most| choice.settles && *most > 0.0),
            tolerance: choice.tolerance,
            omega: choice.omega,
            recovery_speed: choice.recovery.map_or(open.recovery_speed, |share| share * (gravity * radius).sqrt()),
            rest_gap: choice.near.map_or(open.rest_gap, |[rest, _]| rest * radius),
            rest_speed: choice.near.map_or(open.rest_speed, |_| RESTS * model.gravity.length() * step),
            envelope: choice.near.map(|_| (FALLS * fall).clamp(radius / 50.0, radius / 8.0)),
            recycle: choice.near.map(|[_, recycle]| recycle * radius),
            ..open
        };
        // A whole number of steps a second.
        (given.unwrap_or(1.0 / (1.0 / step).ceil()), solver)
    }
}

impl ModelFile {
    /// Fill in what the file leaves open of its step and its solver, from its `quality`; nothing without one. `doc` tells what it gives.
    ///
    /// # Errors
    /// Those of [`ModelFile::resolve`].
    pub fn choose(&mut self, doc: &Document) -> Result<(), Fault> {
        let Some(quality) = self.quality else { return Ok(()) };
        let (resolved, _) = self.build(doc)?;
        let given = doc.has("step").then_some(self.step);
        let (step, chosen) = quality.settings(&resolved.model, &resolved.state, given);
        let is_open = |key: &str| !doc.has(key);
        let own = &mut self.solver;
        // What belongs to a method is chosen for the chosen one alone, whether it is given or not.
        if is_open("solver.method") || own.method == chosen.method {
            own.method = chosen.method;
            let fill = |key: &str| is_open(&format!("solver.{key}"));
            own.iterations = if fill("iterations") { chosen.iterations } else { own.iterations };
            own.omega = if fill("omega") { chosen.omega } else { own.omega };
            // Iterations that are given are the most.
            if fill("iterations") {
                own.overlap_tolerance = own.overlap_tolerance.or(chosen.overlap_tolerance);
                own.settling_tolerance = own.settling_tolerance.or(chosen.settling_tolerance);
            }
        }
        macro_rules! fill {
            ($($key:ident),*) => {
                $(if is_open(concat!("solver.", stringify!($key))) {
                    own.$key = chosen.$key;
                })*
            };
        }
        fill!(friction, start_iterations, tolerance, recovery_speed, rest_gap, rest_speed, envelope, recycle);
        if let Some(envelope) = own.envelope.filter(|_| is_open("solver.rest_gap")) {
            own.rest_gap = own.rest_gap.min(envelope);
        }
        self.step = step;
        Ok(())
    }
}
