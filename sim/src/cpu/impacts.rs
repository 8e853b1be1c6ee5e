//! Impacts one after another: Newton's law of restitution for the pair that closes fastest, until none closes.
//!
//! The contact problem has one solution for all impacts of a step at once. Where bodies touch in a row, as in a cradle, the impact then does
//! not go through them one by one. With `impacts: sequential` the pairs that bounce are taken first, without friction and joints, which the
//! contact problem adds; contacts that still close, as after too many impacts, are closed by it.

use super::masses::Masses;
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;

/// Minimum approach speed for restitution, m/s: what gravity adds in two steps does not bounce.
pub fn least_speed(model: &Model) -> f64 {
    1e-3f64.max(2.0 * model.gravity.length() * model.step)
}

/// Whether a contact at a gap, m, that closes at `speed`, m/s (negative), bounces within the step.
pub fn bounces(model: &Model, gap: f64, speed: f64) -> bool {
    speed < -least_speed(model) && gap + model.step * speed <= 0.0
}

/// Change the velocities at the step's end without contacts and joints, `free` (n_bodies), by the impacts of the step.
pub fn run(model: &Model, state: &State, masses: &Masses, free: &mut [Twist]) {
    /// The most impacts of a contact in a step, in the mean.
    const MOST: usize = 100;
    let contacts = &state.contacts;
    let restitution = |i: usize| model.laws[contacts.law[i] as usize].restitution;
    let speed = |motion: &[Twist], i: usize| contacts.velocity(i, |b| motion[b]).dot(contacts.normal[i]);
    let mut motion: Vec<Twist> = (0..model.n_bodies()).map(|b| state.twist(b)).collect();
    let can_bounce: Vec<usize> = (0..contacts.len()).filter(|i| restitution(*i) > 0.0).collect();
    for _ in 0..MOST * can_bounce.len() {
        let closing = can_bounce.iter().map(|i| (*i, speed(&motion, *i)));
        let bouncing = closing.filter(|(i, speed)| bounces(model, contacts.gap[*i], *speed));
        let Some((i, speed)) = bouncing.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let impulse = -(1.0 + restitution(i)) * speed / masses.normal_response(contacts, i);
        let ([a, b], [arm_a, arm_b]) = (contacts.bodies[i], contacts.arms(i));
        let push = contacts.normal[i] * impulse;
        for motion in [&mut motion[..], &mut *free] {
            masses.apply_impulse(motion, a, -push, -arm_a.cross(push));
            masses.apply_impulse(motion, b, push, arm_b.cross(push));
        }
    }
}
