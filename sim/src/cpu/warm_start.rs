//! Start each contact from the impulse that the same contact had in the last step.
//! in   old      contacts of the last step, with their impulses
//!      contacts [n_contacts]  all but the impulses
//! out  impulse  [n_contacts]  N s, world; zero for a new contact
//!      twist    [n_contacts]  N m s, world, where the model has rolling or spinning friction
//! Source: PHYSICS, "warm start from the last step's γ of the same pair".

use super::fill_rows;
use crate::{Contacts, Model};
use glam::DVec3;

/// The stage.
pub fn run(model: &Model, old: &Contacts, contacts: &mut Contacts) {
    let mut impulse = std::mem::take(&mut contacts.impulse);
    let mut twist = std::mem::take(&mut contacts.twist);
    let rolls = model.laws.iter().any(|l| l.rolling > 0.0 || l.spinning > 0.0);
    impulse.resize(contacts.len(), DVec3::ZERO);
    twist.resize(if rolls { contacts.len() } else { 0 }, DVec3::ZERO);
    if model.solver.warm_start {
        let same = |i: usize| same_contact(old, contacts.bodies[i], contacts.key[i]);
        fill_rows(&mut impulse, |i| same(i).map_or(DVec3::ZERO, |j| old.impulse[j]));
        fill_rows(&mut twist, |i| same(i).and_then(|j| old.twist.get(j).copied()).unwrap_or_default());
    } else {
        impulse.fill(DVec3::ZERO);
        twist.fill(DVec3::ZERO);
    }
    contacts.impulse = impulse;
    contacts.twist = twist;
}

/// The old contact of the same key, looked for in the shorter list of the two bodies.
fn same_contact(old: &Contacts, [a, b]: [u32; 2], key: [u32; 3]) -> Option<usize> {
    let (of_a, of_b) = (old.of_body(a as usize), old.of_body(b as usize));
    let list = if of_a.len() < of_b.len() { of_a } else { of_b };
    list.iter().map(|i| *i as usize / 2).find(|&i| old.key[i] == key)
}
