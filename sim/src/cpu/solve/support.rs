//! Impulses of rest: a starting point for bodies that stand on each other, before any step has been solved.
//!
//! From above downwards, each body hands its weight and what rests on it to the contacts below it, as vertical forces that balance its force
//! and its moments: the least ones by their squares, those that would pull left out. For walls, stacks and pyramids that is equilibrium; for
//! anything else it is a guess, which the solve goes on from.

use crate::contacts::Contacts;
use crate::model::Model;
use crate::state::State;
use glam::{DMat3, DVec3};
use gpu::radix_sort::distribute_cpu;

/// Least cosine between a contact's normal and the vertical for it to carry weight.
const STEEP: f64 = 0.5;

/// A contact that carries weight: its index, the body on top and the one below.
struct Support {
    contact: usize,
    above: usize,
    below: usize,
}

/// Set the impulses of contacts without any to those that carry the bodies' weight for a step.
pub fn fill(model: &Model, state: &State, contacts: &mut Contacts) {
    let gravity = model.gravity.length();
    let Some(up) = (-model.gravity).try_normalize() else { return };
    let open = model.solver.rest_gap + 0.5 * gravity * model.step * model.step;
    let supports: Vec<Support> = (0..contacts.len()).filter_map(|i| support(contacts, i, up, open)).collect();
    // The contacts below each body, and the number of those above it that are still to come.
    let (mut first, mut of_body) = (vec![], vec![]);
    let by_body = || (0..supports.len()).map(|k| (supports[k].above as u32, k as u32));
    distribute_cpu(model.n_bodies(), by_body, &mut first, &mut of_body);
    let mut waiting = vec![0u32; model.n_bodies()];
    supports.iter().for_each(|support| waiting[support.below] += 1);
    let weight = |b: usize| if state.moves(b) { gravity / model.inv_mass[b] } else { 0.0 };
    // Force down and moment about the centre of mass of each body, by gravity and by what rests on it.
    let mut load: Vec<(f64, DVec3)> = (0..model.n_bodies()).map(|b| (weight(b), DVec3::ZERO)).collect();
    let mut ready: Vec<usize> = (0..model.n_bodies()).filter(|b| waiting[*b] == 0).collect();
    let mut at = 0;
    while at < ready.len() {
        let body = ready[at];
        at += 1;
        let own = &of_body[first[body] as usize..first[body + 1] as usize];
        let arms: Vec<DVec3> = own.iter().map(|k| arm(contacts, &supports[*k as usize], body)).collect();
        let forces = if state.moves(body) { balance(load[body], &arms, up) } else { vec![0.0; own.len()] };
        for (k, force) in own.iter().zip(forces) {
            let Support { contact, below, .. } = supports[*k as usize];
            let is_on_b = contacts.bodies[contact][1] as usize == body;
            contacts.impulse[contact] = up * (if is_on_b { force } else { -force } * model.step);
            load[below].0 += force;
            load[below].1 -= arm(contacts, &supports[*k as usize], below).cross(up) * force;
            waiting[below] -= 1;
            if waiting[below] == 0 {
                ready.push(below);
            }
        }
    }
}

/// A contact as a support: one that is closed, up to a gap of `open`, m, and not too steep.
fn support(contacts: &Contacts, i: usize, up: DVec3, open: f64) -> Option<Support> {
    let rise = contacts.normal[i].dot(up);
    let [a, b] = contacts.bodies[i].map(|b| b as usize);
    let (above, below) = if rise > 0.0 { (b, a) } else { (a, b) };
    (rise.abs() >= STEEP && contacts.gap[i] <= open).then_some(Support { contact: i, above, below })
}

/// Arm of a support on one of its two bodies, m.
fn arm(contacts: &Contacts, support: &Support, body: usize) -> DVec3 {
    let side = usize::from(contacts.bodies[support.contact][1] as usize == body);
    contacts.arms(support.contact)[side]
}

/// Upward forces at points, arms from the centre of mass, that balance a downward force and a moment, as far as they can push; N.
fn balance((weight, moment): (f64, DVec3), arms: &[DVec3], up: DVec3) -> Vec<f64> {
    let mut pushes = vec![true; arms.len()];
    // Each round leaves out the contacts that would pull.
    for _ in 0..arms.len() {
        let active = || arms.iter().zip(&pushes).filter(|(_, pushes)| **pushes).map(|(arm, _)| *arm);
        let n = active().count();
        if n == 0 {
            break;
        }
        // Rows: the force, and the two moments across gravity, with arms over their greatest length so that all are alike.
        let (u, w) = up.any_orthonormal_pair();
        let length = active().map(|arm| arm.length()).fold(0.0, f64::max).max(1e-300);
        let row = |arm: DVec3| {
            let turn = arm.cross(up) / length;
            DVec3::new(1.0, turn.dot(u), turn.dot(w))
        };
        let wanted = DVec3::new(weight, -moment.dot(u) / length, -moment.dot(w) / length);
        let mut normal = DMat3::from_diagonal(DVec3::splat(1e-9 * n as f64));
        for r in active().map(row) {
            normal += DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        }
        let multiplier = normal.inverse() * wanted;
        let forces: Vec<f64> =
            arms.iter().zip(&pushes).map(|(arm, on)| if *on { row(*arm).dot(multiplier) } else { 0.0 }).collect();
        if forces.iter().all(|force| *force >= 0.0) {
            return forces;
        }
        forces.iter().zip(&mut pushes).for_each(|(force, pushes)| *pushes &= *force > 0.0);
    }
    vec![0.0; arms.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_balance_weight_and_moment() {
        let arms = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, -0.5));
        // A weight of 8 N with its load 0.25 m off the middle.
        let load = DVec3::new(0.25, 0.0, 0.0).cross(-DVec3::Z) * 8.0;
        let forces = balance((8.0, load), &arms, DVec3::Z);
        for (force, expected) in forces.iter().zip([1.5, 2.5, 2.5, 1.5]) {
            assert!((force - expected).abs() < 1e-6, "{forces:?}");
        }
        // Beyond the supports, those that would pull are left out.
        let load = DVec3::new(0.9, 0.9, 0.0).cross(-DVec3::Z) * 8.0;
        let forces = balance((8.0, load), &arms, DVec3::Z);
        assert!(forces.iter().all(|force| *force >= 0.0) && forces.iter().sum::<f64>() > 7.9, "{forces:?}");
    }
}
