//! Sleep: bodies that rest are left where they are until something concerns them.
//!
//! An *island* is what hangs together by contacts, joints and springs between bodies that move. It falls asleep after a step at whose end each
//! of its bodies has been slower than `sleep` for half a second, and no load or motor acts on any. Its bodies then count as held in place, with
//! no velocity; its contacts, joints and springs keep their last forces for whoever reads them.
//!
//! An island wakes as a whole when a body that moves touches one of its bodies, when a load or a motor acts on one, when a joint or spring of
//! one begins or ends to act, and when any body appears or begins to move on schedule. A step that finds that a sleeping body is touched is
//! done again with it awake, so that no impulse is lost to what is held. The contacts start from the impulses that they had.
//!
//! What would wake an island is what belongs to it (`touches`), so that neighbours do not wake each other in turn.

use crate::contacts::Contacts;
use crate::joint::{Joint, Motor, Spring};
use crate::load::Function;
use crate::model::Model;
use crate::sleepers::{AWAKE, Sleepers};
use crate::state::{Activity, State};
use glam::DVec3;

/// Time for which all bodies of an island have been still when it falls asleep, s.
const STILL_FOR: f64 = 0.5;

/// Number of steps from one search for islands to the next.
const EVERY: u64 = 8;

/// Wake what something other than a touch concerns in the step that begins now; all, if `has_changed`, or if no body may sleep any more. Returns
/// whether any body has woken.
pub fn rouse_driven(model: &Model, state: &mut State, has_changed: bool) -> bool {
    if state.sleepers.n == 0 {
        return false;
    }
    let (start, h) = (state.time, model.step);
    let own = &state.sleepers.island;
    let islands: Vec<u32> = if has_changed || model.solver.sleep.is_none() {
        own.clone()
    } else {
        let switches = |acts: &dyn Fn(f64) -> bool| acts(start) != acts(start - h);
        let joints = model.joints.iter().filter(|j| drives(j, start, h) || switches(&|t| j.acts(t)));
        let springs = model.springs.iter().filter(|s| pulls(s, start) || switches(&|t| s.acts(t)));
        let bodies = joints.flat_map(|j| j.bodies).chain(springs.flat_map(|s| s.bodies)).chain(loaded(model, state));
        bodies.map(|b| own[b as usize]).collect()
    };
    rouse(state, islands)
}

/// The islands that bodies that move touch in a step: once its contacts are known, those that will be touched by the velocities so far, and
/// once it `is_solved`, those that have been.
pub fn touched(model: &Model, state: &State, is_solved: bool) -> Vec<u32> {
    let c = &state.contacts;
    let is_touched = |i: &usize| {
        let activity = c.bodies[*i].map(|b| state.activity[b as usize]);
        matches!(activity, [Activity::Moving, Activity::Asleep] | [Activity::Asleep, Activity::Moving])
            && if is_solved { c.impulse[*i] != DVec3::ZERO } else { touches(model, state, *i) }
    };
    let bodies = (0..c.len()).filter(is_touched).flat_map(|i| c.bodies[i]);
    bodies.map(|b| state.sleepers.island[b as usize]).collect()
}

/// Wake all bodies.
pub fn rouse_all(state: &mut State) {
    let all = state.sleepers.island.clone();
    rouse(state, all);
}

/// Wake islands: their contacts are added to those of the last step. Returns whether any body has woken.
pub fn rouse(state: &mut State, mut islands: Vec<u32>) -> bool {
    islands.sort_unstable();
    islands.dedup();
    let before = state.sleepers.n;
    let wakes = |island: u32| island != AWAKE && islands.binary_search(&island).is_ok();
    let asleep = std::mem::take(&mut state.sleepers.contacts);
    for i in 0..asleep.len() {
        let own = asleep.bodies[i].map(|b| state.sleepers.island[b as usize]);
        let to = if own.into_iter().any(wakes) { &mut state.contacts } else { &mut state.sleepers.contacts };
        to.push_of(&asleep, i);
    }
    let Sleepers { island, still, n, .. } = &mut state.sleepers;
    for b in 0..island.len() {
        if wakes(island[b]) {
            (island[b], still[b]) = (AWAKE, 0);
            state.activity[b] = Activity::Moving;
            *n -= 1;
        }
    }
    let has_woken = *n != before;
    if has_woken {
        // The broad phase has left out pairs of bodies that do not move.
        state.fat_aabb = None;
    }
    has_woken
}

/// Let islands fall asleep whose bodies have been slower than `speed`, m/s, for long enough. Runs after a step. Returns whether any has.
pub fn fall_asleep(model: &Model, state: &mut State, speed: f64) -> bool {
    let n = model.n_bodies();
    let mut still = std::mem::take(&mut state.sleepers.still);
    still.resize(n, 0);
    for (b, still) in still.iter_mut().enumerate() {
        let is_slow = || {
            let turning = state.angular_velocity[b].length_squared() * model.gyration(b).powi(2);
            state.velocity[b].length_squared() + turning <= speed * speed
        };
        *still = if state.moves(b) && is_slow() { still.saturating_add(1) } else { 0 };
    }
    let enough = (STILL_FOR / model.step).ceil() as u32;
    let is_due = state.steps.is_multiple_of(EVERY) && still.iter().any(|steps| *steps >= enough);
    let before = state.sleepers.n;
    if is_due {
        put_to_sleep(model, state, |b| still[b] >= enough);
    }
    state.sleepers.still = still;
    state.sleepers.n != before
}

/// Let the islands fall asleep all of whose bodies are still.
fn put_to_sleep(model: &Model, state: &mut State, is_still: impl Fn(usize) -> bool) {
    let (start, h) = (state.time, model.step);
    let mut islands = Islands((0..model.n_bodies() as u32).collect());
    let mut connect = |bodies: [u32; 2]| {
        if bodies.iter().all(|b| state.moves(*b as usize)) {
            islands.join(bodies);
        }
    };
    let c = &state.contacts;
    let belongs: Vec<bool> = (0..c.len()).map(|i| c.impulse[i] != DVec3::ZERO || touches(model, state, i)).collect();
    (0..c.len()).filter(|i| belongs[*i]).for_each(|i| connect(c.bodies[i]));
    model.joints.iter().filter(|j| j.acts(start)).for_each(|j| connect(j.bodies));
    model.springs.iter().filter(|s| s.acts(start)).for_each(|s| connect(s.bodies));
    let driven = model.joints.iter().filter(|j| drives(j, start, h)).flat_map(|j| j.bodies);
    let pulled = model.springs.iter().filter(|s| pulls(s, start)).flat_map(|s| s.bodies);
    let restless = (0..model.n_bodies() as u32).filter(|b| state.moves(*b as usize) && !is_still(*b as usize));
    let mut stays = vec![false; model.n_bodies()];
    for b in driven.chain(pulled).chain(loaded(model, state)).chain(restless) {
        stays[islands.of(b) as usize] = true;
    }
    let mut sleepers = std::mem::take(&mut state.sleepers);
    sleepers.island.resize(model.n_bodies(), AWAKE);
    let falls = |b: u32, islands: &mut Islands| state.moves(b as usize) && !stays[islands.of(b) as usize];
    let falling: Vec<u32> = (0..model.n_bodies() as u32).filter(|b| falls(*b, &mut islands)).collect();
    if !falling.is_empty() {
        falling.iter().for_each(|b| sleepers.island[*b as usize] = islands.of(*b));
        sleepers.n += falling.len();
        let is_asleep = |b: u32| sleepers.island[b as usize] != AWAKE;
        let (mut rest, contacts, c) = (Contacts::default(), &mut sleepers.contacts, &state.contacts);
        for i in 0..c.len() {
            // Those that are open, and those with other bodies, which do not touch, are found again.
            match (c.bodies[i].into_iter().any(is_asleep), belongs[i]) {
                (false, _) => rest.push_of(c, i),
                (true, true) => contacts.push_of(c, i),
                (true, false) => {}
            }
        }
        state.contacts = rest;
        state.fat_aabb = None;
        for b in falling {
            let b = b as usize;
            state.activity[b] = Activity::Asleep;
            (state.velocity[b], state.angular_velocity[b]) = (DVec3::ZERO, DVec3::ZERO);
        }
        for (joint, now) in model.joints.iter().zip(&mut state.joints) {
            if joint.bodies.iter().any(|b| state.activity[*b as usize] == Activity::Asleep) {
                now.rate = 0.0;
            }
        }
    }
    state.sleepers = sleepers;
}

/// Whether a contact of the last step is closed, or will be within a step: what falls from rest moves by g h² in a step.
fn touches(model: &Model, state: &State, i: usize) -> bool {
    let (c, h) = (&state.contacts, model.step);
    let opening = c.velocity(i, |b| state.twist(b)).dot(c.normal[i]).min(0.0);
    c.gap[i] + h * opening <= model.solver.rest_gap + model.gravity.length() * h * h
}

/// Whether a joint's motor acts in a step from `start` of length `h`, s, or its length changes.
fn drives(joint: &Joint, start: f64, h: f64) -> bool {
    let is_driven = match &joint.motor {
        Some(Motor::Speed(_) | Motor::Position(_)) => true,
        Some(Motor::Effort(effort)) => effort.at(start + 0.5 * h) != 0.0,
        None => false,
    };
    joint.acts(start) && (is_driven || !matches!(joint.length, Function::Constant(_)))
}

/// Whether a spring's preload varies while it acts.
fn pulls(spring: &Spring, start: f64) -> bool {
    spring.acts(start) && !matches!(spring.preload, Function::Constant(_))
}

/// The bodies on which a load acts in the step that begins now.
fn loaded<'a>(model: &'a Model, state: &State) -> impl Iterator<Item = u32> + use<'a> {
    let middle = state.time + 0.5 * model.step;
    let acts = move |l: &&crate::load::Load| middle >= l.from && middle < l.until && l.value.at(middle) != 0.0;
    model.loads.iter().filter(acts).map(|l| l.body)
}

/// Disjoint sets of bodies: of each body another one of its set with a lower id, or itself.
struct Islands(Vec<u32>);

impl Islands {
    /// The lowest id of a body's set.
    fn of(&mut self, mut b: u32) -> u32 {
        while self.0[b as usize] != b {
            let next = self.0[b as usize];
            self.0[b as usize] = self.0[next as usize];
            b = next;
        }
        b
    }

    fn join(&mut self, bodies: [u32; 2]) {
        let [a, b] = bodies.map(|b| self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
