//! Write the rows of joints, motors and springs; those of limits that may be met in the step are the last of their joints.
//! in     position     [n_bodies]      m
//! in     orientation  [n_bodies]
//! out    joint_start  [n_joints + 1]  first row of each joint, and of the springs
//! out    joint_row    [n_rows]        dΨ/dt and Ψ in the world frame
//! out    joint_kept   [n_rows]        what the step leaves of Ψ, m or rad; 0 of springs
//! out    joint_bias   [n_rows]        (Ψ − kept)/h − rate, and terms of springs, m/s
//! inout  tensor       [n_tensors]     geometric stiffness is added
//! inout  free         [n_bodies]      explicit springs act on it, and geometric stiffness
//! Source: paper §2, bilateral constraints; springs are implicit where they are too stiff for the step.

use super::geometric_stiffness::{Stiffness, Target, has_light_links, spring_forces};
use super::masses::Masses;
use super::solve::joints::Joints;
use super::solve::limits::Limit;
use super::solve::motors::Motor;
use super::solve::response::Response;
use crate::joint::{Coordinate, Frames, Joint, JointState, Row, Spring, SpringState};
use crate::model::Model;
use crate::outcome::{JointErrors, StepOutcome};
use crate::state::{Activity, State};
use crate::twist::Twist;
use crate::work::{self, Span};
use glam::DVec3;

/// Number of steps within which the speeds of a joint's bodies must be able to bring it to a limit for the limit to have a row.
const LOOK_AHEAD: f64 = 3.0;

/// The output of the stage.
pub struct Output<'a> {
    /// First row of each joint, and of the springs (n_joints + 1).
    pub start: &'a mut Vec<u32>,
    /// The rows.
    pub joints: &'a mut Joints,
    /// Velocities without contacts and joints (n_bodies).
    pub free: &'a mut [Twist],
}

/// The stage. Joints with an inactive body do not act yet.
pub fn run(model: &Model, state: &State, masses: &mut Masses, Output { start, joints, free }: Output) {
    let h = model.step;
    let end = state.time + h;
    start.clear();
    joints.rows.clear();
    joints.bias.clear();
    joints.kept.clear();
    joints.motors.start(h);
    (joints.is_factorised, joints.part) = (false, model.part);
    joints.limits.clear();
    let frames: Vec<Option<Frames>> =
        model.joints.iter().map(|joint| joint_acts(state, joint).then(|| state.joint_frames(joint))).collect();
    for (i, (joint, f)) in model.joints.iter().zip(&frames).enumerate() {
        let first = joints.rows.len();
        start.push(first as u32);
        let Some(f) = f else { continue };
        joint.rows(f, &state.joints[i], (end, h), &mut joints.rows);
        push_bias(model, state, joint, joints);
        if let Some(most) = joint.max_effort(state.time + 0.5 * h) {
            let row = joints.rows.len() - 1;
            let [rate, ahead] = joint.prescribed(&joints.rows[row], state.time, end);
            let motor = Motor {
                joint: i as u32,
                row: row as u32,
                most: h * most,
                rate,
                ahead,
                side: state.joints[i].motor_side,
                aim: rate,
            };
            let row = &joints.rows[row];
            joints.motors.push(motor, (masses.response(row), row.speed_in(free)));
        }
        push_limits(model, state, (i, f), free, joints);
    }
    start.push(joints.rows.len() as u32);
    let mut stiffness =
        stiffness(model, state, &frames, |i, _| [state.joints[i].force_world, state.joints[i].force_before]);
    let is_stiff = stiffness.apply(model, state, h, Target { masses, free, joints });
    push_springs(model, state, Target { masses, free, joints });
    // At the start no force is known.
    if is_stiff || state.steps == 0 {
        follow((model, state, &frames), &mut stiffness, start, Target { masses, free, joints });
    }
    (joints.is_light, joints.is_stiff) = (stiffness.is_light, is_stiff);
}

/// Write the rows of the limits of a joint with the frames `f` that may be met in the step; `free` are the velocities without joints.
fn push_limits(model: &Model, state: &State, (i, f): (usize, &Frames), free: &[Twist], joints: &mut Joints) {
    /// Distance from a limit at which a joint is there, m or rad.
    const AT: f64 = 1e-7;
    let (joint, h) = (&model.joints[i], model.step);
    let limits = joint.limits.filter(|_| joint.locked_at().is_none());
    let (Some([min, _]), Some(c)) = (limits, joint.kind.coordinate()) else { return };
    let (at, free_row) = (joint.coordinate(f, &state.joints[i]), joint.free_row(f, c));
    let [a, b] = joint.bodies.map(|b| state.twist(b as usize));
    let reach = LOOK_AHEAD * h * free_row.speeds(a, b) + near(c);
    for is_most in [false, true] {
        // A length is never below 0, where it has no direction.
        let is_bound = is_most || c != Coordinate::Length || min > 0.0;
        if !is_bound || joint.room(at, is_most) > reach {
            continue;
        }
        let row = joint.limit_row(&free_row, at, is_most);
        let back = model.solver.recovery_speed * h;
        let kept = kept(model, state, &row).min(row.psi + back).min(0.0);
        let rate = (row.psi - kept) / h;
        // What a joint is at holds or not as in the last step; it is taken to come to what it would pass without joints.
        let was_held = state.joints[i].held[usize::from(is_most)];
        let is_there = state.steps > 0 && row.psi <= AT;
        let is_held = was_held || !is_there && rate + row.speed_in(free) < AT / h;
        let limit = Limit { joint: i as u32, row: joints.rows.len() as u32, is_most, is_held, rate, curve: 0.0 };
        joints.limits.push(limit);
        joints.push(row, kept, rate);
    }
}

/// What a part of a step leaves of the Ψ of a row, m or rad: of a gap that is more than its bodies move by.
fn kept(model: &Model, state: &State, row: &Row) -> f64 {
    /// Rate of a gap that is made good at once, over the speed of the joint's bodies.
    const AT_ONCE: f64 = 1e-3;
    let [a, b] = row.bodies.map(|b| state.twist(b as usize));
    let is_put_off = model.part < 1.0 && row.psi.abs() > model.step * AT_ONCE * row.speeds(a, b);
    if is_put_off { (1.0 - model.part) * row.psi } else { 0.0 }
}

/// Write the bias of the last rows, those of a joint, and what the step leaves of their Ψ.
///
/// A step that found no solution leaves a gap ([`super::arcs`]). A part of a step does not make it good in its own short time, by speeds that
/// a bridge with little slack would multiply, but in that of a whole step. What motors prescribe is never put off.
fn push_bias(model: &Model, state: &State, joint: &Joint, joints: &mut Joints) {
    let (h, first) = (model.step, joints.bias.len());
    let rows = &joints.rows[first..];
    let bound = model.solver.recovery_speed.max(1.0) / h;
    for (k, row) in rows.iter().enumerate() {
        let kept = if joint.drives(k, rows.len()) { 0.0 } else { kept(model, state, row) };
        joints.kept.push(kept);
        joints.bias.push(((row.psi - kept) / h).clamp(-bound, bound) - row.rate);
    }
}

/// Write the rows of the springs that are implicit, and have the others act on the velocities.
fn push_springs(model: &Model, state: &State, Target { masses, free, joints }: Target) {
    let h = model.step;
    for (i, spring) in model.springs.iter().enumerate() {
        if !spring_acts(state, spring) {
            continue;
        }
        let f = state.spring_frames(spring);
        let (k, c) = (spring.stiffness, spring.damping);
        for row in spring.rows(&f, &state.springs[i]) {
            // Explicit in position (symplectic, no numerical damping) while h²k/m is small, implicit beyond.
            let response = masses.response(&row);
            let theta = if h * h * k * response < 1.0 { 0.0 } else { 1.0 };
            let tension = spring.tension(row.psi, state.time + h);
            let damping = c + theta * h * k;
            if damping > 0.0 {
                // λ = −h (tension + damping u), or u + λ/(h damping) + tension/damping = 0.
                joints.push(Row { softness: 1.0 / (h * damping), ..row }, 0.0, tension / damping);
            } else {
                masses.apply_row_impulse(free, &row, -h * tension);
            }
        }
    }
}

/// Let the stiffness follow the forces of the step itself, as they are without contacts.
fn follow(
    (model, state, frames): (&Model, &State, &[Option<Frames>]),
    stiffness: &mut Stiffness,
    start: &[u32],
    Target { masses, free, joints }: Target,
) {
    /// The most times: each makes the forces smaller.
    const MOST: usize = 3;
    let h = model.step;
    let mut response = Response::default();
    for _ in 0..MOST {
        joints.prepare(masses);
        response.twist.clear();
        response.twist.extend_from_slice(free);
        joints.reset(&mut response);
        joints.solve(masses, &mut response);
        let found = self::stiffness(model, state, frames, |i, f| {
            let range = start[i] as usize..start[i + 1] as usize;
            let force = f.reaction(&joints.rows[range.clone()], &response.lambda[range], h).0;
            [force, force]
        });
        if !stiffness.follow(&found, model, state, h, Target { masses, free, joints }) {
            joints.is_factorised = joints.motors.is_empty();
            break;
        }
    }
}

/// The geometric stiffness of the joints that act, those with frames, by their forces now and before, and of the springs.
fn stiffness(
    model: &Model,
    state: &State,
    frames: &[Option<Frames>],
    forces: impl Fn(usize, &Frames) -> [DVec3; 2],
) -> Stiffness {
    let springs = model.springs.iter().enumerate().filter(|(_, spring)| spring_acts(state, spring));
    let springs: Vec<(usize, &Spring, Frames)> = springs.map(|(i, s)| (i, s, state.spring_frames(s))).collect();
    let of_joint = |(i, f): (usize, &Option<Frames>)| f.as_ref().map(|f| forces(i, f));
    let forces: Vec<_> = frames.iter().enumerate().map(of_joint).collect();
    let joints = || model.joints.iter().zip(frames).zip(&forces).enumerate();
    let of_joints =
        joints().filter_map(|(_, ((joint, f), forces))| Some((joint.bodies, f.as_ref()?, forces.as_ref()?[0])));
    let of_springs = springs.iter().map(|(i, s, f)| (s.bodies, f, spring_forces(s, f, &state.springs[*i])[0]));
    let mut stiffness = Stiffness::new(model, of_joints.chain(of_springs));
    stiffness.is_light = has_light_links(model, state, frames);
    for (i, ((joint, f), forces)) in joints() {
        if let (Some(f), Some(forces)) = (f, forces) {
            stiffness.add((i, joint), f, *forces, |b| state.moves(b as usize));
        }
    }
    for (i, spring, f) in &springs {
        stiffness.add_spring((model.joints.len() + i, spring), f, &state.springs[*i]);
    }
    stiffness
}

/// Whether a joint acts in the step: it does not yet with an inactive body.
fn joint_acts(state: &State, joint: &Joint) -> bool {
    joint.acts(state.time) && are_present(state, joint.bodies)
}

/// [`joint_acts`] of a spring.
fn spring_acts(state: &State, spring: &Spring) -> bool {
    spring.acts(state.time) && are_present(state, spring.bodies)
}

/// Whether no body is inactive, and one at least moves.
fn are_present(state: &State, bodies: [u32; 2]) -> bool {
    let mut bodies = bodies.into_iter().map(|b| b as usize);
    !bodies.clone().any(|b| state.is_inactive(b)) && bodies.any(|b| state.moves(b))
}

/// Record the states of the joints and springs: reactions, those of limits included, coordinates, violations, and the work of what drives the
/// model. Runs before the poses change.
pub fn record(
    model: &Model,
    state: &mut State,
    rows: (&[u32], &Joints),
    response: &Response,
    outcome: &mut StepOutcome,
) {
    (outcome.joints, outcome.work) = (JointErrors::default(), 0.0);
    (outcome.spring_oscillation, outcome.spring_stretch) = (0.0, 0.0);
    let motion = &response.twist;
    let of_loads: f64 = Span { state, motion }.of_loads(model).inspect(|work| outcome.work += work.abs()).sum();
    state.load_work += of_loads;
    record_joints(model, state, rows, response, outcome);
    record_springs(model, state, motion, outcome);
}

/// Whether two bodies keep the last forces between them: one sleeps, and none moves.
fn sleep(state: &State, bodies: [u32; 2]) -> bool {
    let is = |activity: Activity| bodies.iter().any(|b| state.activity[*b as usize] == activity);
    is(Activity::Asleep) && !is(Activity::Moving)
}

fn record_joints(
    model: &Model,
    state: &mut State,
    (start, joints): (&[u32], &Joints),
    response: &Response,
    outcome: &mut StepOutcome,
) {
    let h = model.step;
    let motion = &response.twist;
    for (i, joint) in model.joints.iter().enumerate() {
        if sleep(state, joint.bodies) {
            continue;
        }
        let f = state.joint_frames(joint);
        let limits = joints.limits.of_joint(i as u32);
        let range = start[i] as usize..start[i + 1] as usize - limits.len();
        let (rows, lambda) = (&joints.rows[range.clone()], &response.lambda[range]);
        let known = state.joints[i];
        let mut now = JointState {
            coordinate: joint.coordinate(&f, &known),
            force_before: known.force_world,
            motor_side: joints.motors.of_joint(i as u32).map_or(0.0, |motor| motor.side),
            work: known.work,
            held: [false, true].map(|is_most| limits.iter().any(|limit| limit.is_most == is_most && limit.is_held)),
            ..JointState::default()
        };
        if let Some(c) = joint.kind.coordinate() {
            let row = joint.free_row(&f, c);
            if joint_acts(state, joint) {
                now.violation = joint.beyond_limits(now.coordinate);
                outcome.joints.add(i, &row, now.violation);
            }
            now.rate = row.speed_in(motion);
            now.coordinate += h * now.rate;
        }
        let mut drive = |row: &Row, impulse: f64| {
            let work = impulse * Span { state, motion }.mean_speed(row);
            now.effort += impulse / h;
            now.work += work;
            outcome.work += work.abs();
        };
        for (k, row) in rows.iter().enumerate().filter(|(k, _)| joint.drives(*k, rows.len())) {
            drive(row, lambda[k]);
        }
        let is_inactive = joint.bodies.iter().any(|b| state.is_inactive(*b as usize));
        let effort = if joint.acts(state.time) && !is_inactive { joint.effort(state.time + 0.5 * h) } else { 0.0 };
        let given = joint.kind.coordinate().filter(|_| effort != 0.0).map(|c| (joint.free_row(&f, c), h * effort));
        if let Some((row, impulse)) = &given {
            drive(row, *impulse);
        }
        for (k, row) in rows.iter().enumerate() {
            let (error, is_motor) = joint.error(row, k, rows.len(), state.time, state.time + h);
            now.violation = error.max(now.violation);
            if !is_motor {
                outcome.joints.add(i, row, error);
            }
        }
        let mut add = |rows: &[Row], impulses: &[f64]| {
            let (force, torque) = f.reaction(rows, impulses, h);
            now.force_world += force;
            now.torque_world += torque;
        };
        add(rows, lambda);
        given.iter().for_each(|(row, impulse)| add(&[*row], &[*impulse]));
        for limit in limits.iter().filter(|limit| limit.is_held).map(|limit| limit.row as usize) {
            add(&[joints.rows[limit]], &[response.lambda[limit]]);
        }
        let into = f.a.orientation.inverse();
        (now.force, now.torque) = (into * now.force_world, into * now.torque_world);
        state.joints[i] = now;
    }
}

fn record_springs(model: &Model, state: &mut State, motion: &[Twist], outcome: &mut StepOutcome) {
    let h = model.step;
    for (i, spring) in model.springs.iter().enumerate() {
        if sleep(state, spring.bodies) {
            continue;
        }
        let f = state.spring_frames(spring);
        let known = state.springs[i];
        let acts = spring.acts(state.time) && !spring.bodies.iter().any(|b| state.is_inactive(*b as usize));
        let rows = || spring.rows(&f, &known).map(|row| (row.psi, row.speed_in(motion)));
        let mut work = 0.0;
        if acts {
            let power = |(psi, speed): (f64, f64)| (spring.tension(psi, state.time + h) * speed).abs();
            let stretch2: f64 = rows().map(|(_, speed)| (h * speed) * (h * speed)).sum();
            outcome.spring_stretch += 0.5 * spring.stiffness * stretch2;
            outcome.spring_oscillation += h * rows().map(power).sum::<f64>();
            work = work::of_preload(model, state, i);
            outcome.work += work.abs();
        }
        let force = |(psi, speed): (f64, f64)| spring.tension(psi, state.time + h) + spring.damping * speed;
        let force = if acts { spring.coordinate(rows().map(force)) } else { 0.0 };
        let coordinate = spring.coordinate(rows().map(|(psi, speed)| psi + h * speed));
        state.springs[i] = SpringState { force, force_before: known.force, coordinate, work: known.work + work };
    }
}

/// Distance from a limit within which it always has a row, rad or m: what strikes a joint may bring it there within the step.
fn near(coordinate: Coordinate) -> f64 {
    if coordinate == Coordinate::Angle { 0.05 } else { 0.01 }
}
