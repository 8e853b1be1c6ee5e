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
use crate::disjoint_sets::DisjointSets;
use crate::inertia::gyration;
use crate::joint::Joint;
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
    if state.sleepers.are_none() {
        return false;
    }
    if has_changed || model.solver.sleep.is_none() {
        return rouse_all(state);
    }
    let (start, h) = (state.time, model.step);
    let switches = |acts: &dyn Fn(f64) -> bool| acts(start) != acts(start - h);
    let joints = model.joints.iter().filter(|j| switches(&|t| j.acts(t))).flat_map(|j| j.bodies);
    let springs = model.springs.iter().filter(|s| switches(&|t| s.acts(t))).flat_map(|s| s.bodies);
    let islands =
        joints.chain(springs).chain(driven(model, state)).map(|b| state.sleepers.island[b as usize]).collect();
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

/// Wake all bodies. Returns whether any has woken.
pub fn rouse_all(state: &mut State) -> bool {
    let all = state.sleepers.island.clone();
    rouse(state, all)
}

/// Wake islands: their contacts are added to those of the last step. Returns whether any body has woken.
pub fn rouse(state: &mut State, mut islands: Vec<u32>) -> bool {
    islands.sort_unstable();
    islands.dedup();
    let wakes = |island: u32| island != AWAKE && islands.binary_search(&island).is_ok();
    let asleep = std::mem::take(&mut state.sleepers.contacts);
    for i in 0..asleep.len() {
        let own = asleep.bodies[i].map(|b| state.sleepers.island[b as usize]);
        let to = if own.into_iter().any(wakes) { &mut state.contacts } else { &mut state.sleepers.contacts };
        to.push_of(&asleep, i);
    }
    let Sleepers { island, still, .. } = &mut state.sleepers;
    let mut has_woken = false;
    for b in 0..island.len() {
        if wakes(island[b]) {
            (island[b], still[b]) = (AWAKE, 0);
            state.activity[b] = Activity::Moving;
            has_woken = true;
        }
    }
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
            let turning = state.angular_velocity[b].length_squared()
                * gyration(model.inv_mass[b], model.inv_inertia[b].min_element()).powi(2);
            state.velocity[b].length_squared() + turning <= speed * speed
        };
        *still = if state.moves(b) && is_slow() { still.saturating_add(1) } else { 0 };
    }
    let enough = (STILL_FOR / model.step).ceil() as u32;
    let is_due = state.steps.is_multiple_of(EVERY) && still.iter().any(|steps| *steps >= enough);
    let falling = if is_due { still_islands(model, state, |b| still[b] >= enough) } else { vec![] };
    state.sleepers.still = still;
    put_to_sleep(model, state, &falling);
    !falling.is_empty()
}

/// The bodies of the islands all of whose bodies are still, each with its island: the lowest id of its bodies.
fn still_islands(model: &Model, state: &State, is_still: impl Fn(usize) -> bool) -> Vec<(u32, u32)> {
    let start = state.time;
    let bodies = || (0..model.n_bodies() as u32).filter(|b| state.moves(*b as usize));
    let mut islands = DisjointSets::new(model.n_bodies());
    let mut connect = |bodies: [u32; 2]| {
        if bodies.iter().all(|b| state.moves(*b as usize)) {
            islands.join(bodies);
        }
    };
    let c = &state.contacts;
    (0..c.len()).filter(|i| belongs(model, state, *i)).for_each(|i| connect(c.bodies[i]));
    model.joints.iter().filter(|j| j.acts(start)).for_each(|j| connect(j.bodies));
    model.springs.iter().filter(|s| s.acts(start)).for_each(|s| connect(s.bodies));
    let mut stays = vec![false; model.n_bodies()];
    for b in driven(model, state).chain(bodies().filter(|b| !is_still(*b as usize))) {
        stays[islands.of(b) as usize] = true;
    }
    bodies().map(|b| (b, islands.of(b))).filter(|(_, island)| !stays[*island as usize]).collect()
}

/// Let bodies of whole islands fall asleep, with their contacts.
fn put_to_sleep(model: &Model, state: &mut State, falling: &[(u32, u32)]) {
    if falling.is_empty() {
        return;
    }
    let mut sleepers = std::mem::take(&mut state.sleepers);
    sleepers.island.resize(model.n_bodies(), AWAKE);
    falling.iter().for_each(|(b, island)| sleepers.island[*b as usize] = *island);
    let is_asleep = |b: u32| sleepers.island[b as usize] != AWAKE;
    let (mut rest, c) = (Contacts::default(), &state.contacts);
    for i in 0..c.len() {
        if !c.bodies[i].into_iter().any(is_asleep) {
            rest.push_of(c, i);
        } else if belongs(model, state, i) {
            // The others, which are open, are found again.
            sleepers.contacts.push_of(c, i);
        }
    }
    state.contacts = rest;
    state.fat_aabb = None;
    for b in falling.iter().map(|(b, _)| *b as usize) {
        state.activity[b] = Activity::Asleep;
        (state.velocity[b], state.angular_velocity[b]) = (DVec3::ZERO, DVec3::ZERO);
    }
    for (joint, now) in model.joints.iter().zip(&mut state.joints) {
        if joint.bodies.iter().any(|b| state.activity[*b as usize] == Activity::Asleep) {
            now.rate = 0.0;
        }
    }
    state.sleepers = sleepers;
}

/// Whether what a contact of the last step is between belongs to one island: it has an impulse, or touches.
fn belongs(model: &Model, state: &State, i: usize) -> bool {
    state.contacts.impulse[i] != DVec3::ZERO || touches(model, state, i)
}

/// Whether a contact of the last step is closed, or will be within a step: what falls from rest moves by g h² in a step.
fn touches(model: &Model, state: &State, i: usize) -> bool {
    let (c, h) = (&state.contacts, model.step);
    let opening = c.velocity(i, |b| state.twist(b)).dot(c.normal[i]).min(0.0);
    c.gap[i] + h * opening <= model.solver.rest_gap + model.gravity.length() * h * h
}

/// The bodies that a motor, a length or a preload that varies, or a load acts on in the step that begins now.
fn driven<'a>(model: &'a Model, state: &State) -> impl Iterator<Item = u32> + use<'a> {
    let (start, middle) = (state.time, state.time + 0.5 * model.step);
    let varies = |f: &Function| !matches!(f, Function::Constant(_));
    let is_on = move |j: &Joint| j.motor.as_ref().is_some_and(|motor| motor.is_on(middle));
    let joints = model.joints.iter().filter(move |j| j.acts(start) && (is_on(j) || varies(&j.length)));
    let springs = model.springs.iter().filter(move |s| s.acts(start) && varies(&s.preload));
    let loads = model.loads.iter().filter(move |l| l.acts(middle)).map(|l| l.body);
    joints.flat_map(|j| j.bodies).chain(springs.flat_map(|s| s.bodies)).chain(loads)
}
