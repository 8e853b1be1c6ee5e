//! The watch over loads: bodies by far heavier than others, whose weight these carry. Where a solve is cut off, the force on a load may swing between
//! nothing and twice its weight for ever, while the residual, a mean over all contacts, stays small.

use crate::heap::loads;
use crate::model::Model;
use crate::state::State;
use crate::warning::Swing;

/// Acceleration over that of gravity beyond which a load that moves is pushed up, or falls.
const SWINGS: f64 = 0.5;
/// The same of a load at rest, which nothing but the solver moves.
const SWINGS_AT_REST: f64 = 0.25;
/// Speed over that of a fall within a step up to which a load is at rest.
const AT_REST: f64 = 10.0;
/// Steps within which the acceleration of a load that swings changes its sign.
const PERIOD: u64 = 200;
/// Changes of sign, one after another, from which on a load swings.
const TURNS: u32 = 40;
/// Steps after which the loads are looked for again.
const RENEWED: u64 = 64;

/// Look at the loads after a step. Returns the message of a warning about one that swings.
pub fn watch(swings: &mut Vec<Swing>, model: &Model, state: &State, label: impl Fn(u32) -> String) -> Option<String> {
    let gravity = model.gravity.length();
    let is_driven = !model.loads.is_empty() || model.joints.iter().any(|j| j.motor.is_some());
    if gravity == 0.0 || is_driven || !model.springs.is_empty() {
        swings.clear();
        return None;
    }
    let speed = |body: u32| -state.velocity[body as usize].dot(model.gravity) / gravity;
    if state.steps.is_multiple_of(RENEWED) {
        let bodies = loads(model, state);
        swings.retain(|swing| bodies.contains(&swing.body));
        for body in bodies {
            if swings.iter().all(|swing| swing.body != body) {
                swings.push(Swing { body, speed: speed(body), ..Swing::default() });
            }
        }
    }
    let mut message = None;
    for swing in swings {
        let now = speed(swing.body);
        let push = (now - swing.speed) / (gravity * model.step);
        swing.speed = now;
        let is_at_rest = state.velocity[swing.body as usize].length() <= AT_REST * gravity * model.step;
        let least = if is_at_rest { SWINGS_AT_REST } else { SWINGS };
        if push.abs() < least || (push > 0.0) == swing.is_up {
            continue;
        }
        let goes_on = state.steps - swing.turned <= PERIOD;
        swing.turns = if goes_on { swing.turns + 1 } else { 1 };
        (swing.is_up, swing.turned) = (push > 0.0, state.steps);
        if swing.turns >= TURNS && message.is_none() {
            message = Some(format!(
                "the force on body {} swings: {} times, the last time within {PERIOD} steps, it went from less than {} to more than {} times the weight or back",
                label(swing.body),
                swing.turns,
                1.0 - least,
                1.0 + least
            ));
        }
    }
    message
}
