//! What kind of heap a model is: beds, heaps, and the loads on them.

use crate::model::Model;
use crate::state::State;
use std::collections::BTreeSet;

/// Whether a model is a bed: many bodies, without joints, and none by far heavier than another. There Gauss–Seidel measures best.
pub fn is_bed(model: &Model, state: &State) -> bool {
    /// The least number of bodies that move.
    const LEAST: usize = 1_000;
    /// The greatest ratio of their masses.
    const GREATEST: f64 = 1_000.0;
    let moving = || (0..model.n_bodies()).filter(|b| state.is_free(*b)).map(|b| model.inv_mass[b]);
    let (light, heavy) = moving().fold((0f64, f64::INFINITY), |(most, least), x| (most.max(x), least.min(x)));
    model.joints.is_empty() && moving().count() >= LEAST && light <= GREATEST * heavy
}

/// Whether a model is a heap: many bodies, most of which no joint holds.
pub fn is_heap(model: &Model, state: &State) -> bool {
    /// The least number of bodies that move.
    const LEAST: usize = 100;
    /// The greatest share of them that joints hold.
    const HELD: f64 = 0.1;
    let is_moving = |b: &u32| state.is_free(*b as usize);
    let n_moving = (0..model.n_bodies() as u32).filter(is_moving).count();
    let held: BTreeSet<u32> = connected(model).flatten().filter(is_moving).collect();
    n_moving >= LEAST && held.len() as f64 <= HELD * n_moving as f64
}

/// Ids of the loads on a heap: bodies that are by far heavier than the lightest and together outweigh all others that move, as plates on grains.
/// None where one of them is connected to others that move, as the chassis of a vehicle. Under loads other methods than Gauss–Seidel, where they
/// are cut off, leave forces that swing for long.
pub fn loads(model: &Model, state: &State) -> Vec<u32> {
    /// The least ratio of a load's mass to that of the lightest body.
    const LEAST: f64 = 1_000.0;
    loads_from(LEAST, model, state)
}

/// Whether a few sweeps a step are not enough for what some bodies carry: [`loads`] from thirty times the lightest body on.
pub fn carries_loads(model: &Model, state: &State) -> bool {
    const LEAST: f64 = 30.0;
    !loads_from(LEAST, model, state).is_empty()
}

/// [`loads`], from a ratio of masses on.
fn loads_from(ratio: f64, model: &Model, state: &State) -> Vec<u32> {
    let mass = |b: u32| model.inv_mass[b as usize].recip();
    let is_free = |b: &u32| state.is_free(*b as usize);
    let moving = || (0..model.n_bodies() as u32).filter(is_free);
    let least = ratio * moving().map(mass).fold(f64::INFINITY, f64::min);
    let (loads, others): (Vec<u32>, Vec<u32>) = moving().partition(|b| mass(*b) >= least);
    let sum = |bodies: &[u32]| bodies.iter().map(|b| mass(*b)).sum::<f64>();
    let is_held = |pair: [u32; 2]| pair.iter().all(is_free) && pair.iter().any(|b| mass(*b) >= least);
    if sum(&loads) <= sum(&others) || connected(model).any(is_held) { vec![] } else { loads }
}

/// The pairs of bodies that joints and springs connect.
fn connected(model: &Model) -> impl Iterator<Item = [u32; 2]> {
    model.joints.iter().map(|j| j.bodies).chain(model.springs.iter().map(|s| s.bodies))
}

/// Whether nine in ten of the moving bodies but the loads are spheres.
pub fn are_spheres_but(loads: &[u32], model: &Model, state: &State) -> bool {
    let is_other = |b: u32| state.is_free(b as usize) && !loads.contains(&b);
    let others = (0..model.n_bodies() as u32).filter(|b| is_other(*b)).count();
    let odd: BTreeSet<u32> = (0..model.n_shapes())
        .filter(|s| !model.is_centred_sphere(*s))
        .map(|s| model.shape_body[s])
        .filter(|b| is_other(*b))
        .collect();
    10 * odd.len() <= others
}
