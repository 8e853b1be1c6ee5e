//! How fast springs let bodies swing.

use crate::joint::{Row, Spring, SpringState};
use crate::model::Model;
use crate::state::State;

/// Mass of the lightest body of a spring, over the greatest among all of springs, below which the spring counts for none: a chain of light
/// points swings what it carries by far slower than its points.
const LIGHT: f64 = 1e-2;
/// Damping over the critical one from which on a spring does not swing.
const DAMPED: f64 = 0.5;

/// How fast a spring lets its bodies swing.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// Id of the spring.
    pub spring: usize,
    /// With it alone, rad/s.
    pub own: f64,
    /// With all springs of the two bodies, at most, rad/s.
    pub most: f64,
}

/// The rates of the springs with little damping, but for those of bodies by far lighter than others on springs.
pub fn rates(model: &Model, state: &State) -> Vec<Rate> {
    let moving = |spring: &Spring| spring.bodies.map(|b| b as usize).into_iter().filter(|b| model.inv_mass[*b] > 0.0);
    let most = model.springs.iter().flat_map(moving).map(|b| 1.0 / model.inv_mass[b]).fold(0.0, f64::max);
    let parts: Vec<[f64; 2]> = model.springs.iter().map(|spring| parts(model, state, spring)).collect();
    // Stiffness times response of all springs of each body, rad²/s².
    let mut of_body = vec![0.0; model.n_bodies()];
    for (spring, parts) in model.springs.iter().zip(&parts) {
        spring.bodies.iter().zip(parts).for_each(|(b, part)| of_body[*b as usize] += spring.stiffness * part);
    }
    let swings = |(id, spring): (usize, &Spring)| {
        let is_light = moving(spring).any(|b| 1.0 / model.inv_mass[b] < LIGHT * most);
        let [a, b] = spring.bodies.map(|b| of_body[b as usize]);
        let response = parts[id][0] + parts[id][1];
        let rate = Rate { spring: id, own: (spring.stiffness * response).sqrt(), most: (a + b).sqrt() };
        let damping = 0.5 * spring.damping * response / rate.own;
        (!is_light && rate.own > 0.0 && damping < DAMPED).then_some(rate)
    };
    model.springs.iter().enumerate().filter_map(swings).collect()
}

/// The response of a spring's two bodies to an impulse along it, 1/kg or 1/(kg m²): the greatest of its rows.
fn parts(model: &Model, state: &State, spring: &Spring) -> [f64; 2] {
    let frames = state.spring_frames(spring);
    let of = |row: Row| {
        [(0, row.angular_a), (1, row.angular_b)].map(|(side, angular)| {
            let b = spring.bodies[side] as usize;
            let own = state.orientation[b].inverse() * angular;
            row.linear.length_squared() * model.inv_mass[b] + (own * own).dot(model.inv_inertia[b])
        })
    };
    let known = SpringState::default();
    let rows = spring.rows(&frames, &known);
    rows.map(of).max_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1]))).unwrap_or_default()
}
