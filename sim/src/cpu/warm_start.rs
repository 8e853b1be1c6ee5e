//! Start each contact from the impulse that the same contact had in the last step.
//! in   old      contacts of the last step, with gamma
//!      contacts [n_contacts]  all but gamma
//! out  gamma    [n_contacts]  N s; zero for a new contact
//! Source: PHYSICS, "warm start from the last step's γ of the same pair".

use super::fill_rows;
use crate::Contacts;
use crate::state::tangents;
use glam::DVec3;

/// The stage. An impulse is carried over as a vector of the world, since the contact frame may have turned.
pub fn run(old: &Contacts, contacts: &mut Contacts) {
    let mut gamma = std::mem::take(&mut contacts.gamma);
    gamma.resize(contacts.len(), DVec3::ZERO);
    fill_rows(&mut gamma, |i| {
        let Some(j) = same_contact(old, contacts.bodies[i], contacts.key[i]) else { return DVec3::ZERO };
        let (u, w) = tangents(old.normal[j]);
        let impulse = old.normal[j] * old.gamma[j].x + u * old.gamma[j].y + w * old.gamma[j].z;
        let (u, w) = tangents(contacts.normal[i]);
        DVec3::new(impulse.dot(contacts.normal[i]), impulse.dot(u), impulse.dot(w))
    });
    contacts.gamma = gamma;
}

/// The old contact of the same key, looked for in the shorter list of the two bodies.
fn same_contact(old: &Contacts, [a, b]: [u32; 2], key: [u32; 3]) -> Option<usize> {
    let (of_a, of_b) = (old.of_body(a as usize), old.of_body(b as usize));
    let list = if of_a.len() < of_b.len() { of_a } else { of_b };
    list.iter().map(|i| *i as usize / 2).find(|&i| old.key[i] == key)
}
