//! Start each contact from the impulse that the same contact had in the last step.
//! in   last     contacts of the last step, with their impulses
//!      contacts [n_contacts]  all but the impulses
//! out  impulse  [n_contacts]  N s, world; zero for a new contact
//!      twist    [n_contacts]  N m s, world, where the model has rolling or spinning friction
//! Source: PHYSICS, "warm start from the last step's γ of the same pair".

use super::fill_rows;
use crate::state::Incident;
use crate::{Contacts, Model};
use glam::{DVec3, Vec3};

/// What is kept of a step's contacts. A starting point needs no double precision.
#[derive(Default)]
pub struct Last {
    key: Vec<[u32; 3]>,
    impulse: Vec<Vec3>,
    twist: Vec<Vec3>,
    incident: Incident,
}

impl Last {
    /// Take these contacts, and hand their memory to the next.
    pub fn take(&mut self, contacts: &mut Contacts) {
        std::mem::swap(&mut self.key, &mut contacts.key);
        std::mem::swap(&mut self.incident, &mut contacts.incident);
        self.impulse.resize(contacts.impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.impulse, |i| contacts.impulse[i].as_vec3());
        self.twist.resize(contacts.twist.len(), Vec3::ZERO);
        fill_rows(&mut self.twist, |i| contacts.twist[i].as_vec3());
    }

    /// The contact of the same key, looked for in the shorter list of the two bodies.
    fn find(&self, bodies: [u32; 2], key: [u32; 3]) -> Option<usize> {
        let [of_a, of_b] = bodies.map(|b| self.incident.of_body(b as usize));
        let list = if of_a.len() < of_b.len() { of_a } else { of_b };
        list.iter().map(|i| *i as usize / 2).find(|&i| self.key[i] == key)
    }
}

/// The stage.
pub fn run(model: &Model, last: &Last, contacts: &mut Contacts) {
    let mut impulse = std::mem::take(&mut contacts.impulse);
    let mut twist = std::mem::take(&mut contacts.twist);
    let rolls = model.laws.iter().any(|l| l.rolling > 0.0 || l.spinning > 0.0);
    impulse.resize(contacts.len(), DVec3::ZERO);
    twist.resize(if rolls { contacts.len() } else { 0 }, DVec3::ZERO);
    if model.solver.warm_start {
        let same = |i: usize| last.find(contacts.bodies[i], contacts.key[i]);
        fill_rows(&mut impulse, |i| same(i).map_or(DVec3::ZERO, |j| last.impulse[j].as_dvec3()));
        fill_rows(&mut twist, |i| same(i).and_then(|j| last.twist.get(j)).map_or(DVec3::ZERO, |t| t.as_dvec3()));
    } else {
        impulse.fill(DVec3::ZERO);
        twist.fill(DVec3::ZERO);
    }
    contacts.impulse = impulse;
    contacts.twist = twist;
}
